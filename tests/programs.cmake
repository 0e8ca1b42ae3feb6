# Writes programs.txt into the build folder: every executable of the build, one a line, relative to that folder. It is
# what the test law/docs holds the pages against.
function(piste_executables_of directory result)
  get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  set(found)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "EXECUTABLE")
      list(APPEND found ${target})
    endif()
  endforeach()
  foreach(folder IN LISTS folders)
    piste_executables_of(${folder} below)
    list(APPEND found ${below})
  endforeach()
  set(${result} ${found} PARENT_SCOPE)
endfunction()

function(piste_write_programs)
  piste_executables_of(${PROJECT_SOURCE_DIR} programs)
  list(TRANSFORM programs REPLACE "(.+)" "$<PATH:RELATIVE_PATH,$<TARGET_FILE:\\1>,${PROJECT_BINARY_DIR}>")
  list(JOIN programs "\n" lines)
  file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/programs.txt CONTENT "${lines}\n")
endfunction()

cmake_language(DEFER DIRECTORY ${PROJECT_SOURCE_DIR} CALL piste_write_programs)  # once all folders are read
