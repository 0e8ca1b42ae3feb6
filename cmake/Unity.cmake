option(PISTE_UNITY "Compile neighbouring files of a folder together" OFF)

# Adds the files NAME.cpp of FOLDER, which lies in `root`, or FOLDER/NAME.cpp where FOLDER is `*`, compiled with the further
# options PISTE_SOURCE_OPTIONS. With PISTE_UNITY up to sixteen of them are compiled as one unit, as most of a file's time goes
# into headers and templates that its neighbours need too. Units stay within a call, so that a
# new file changes none elsewhere; each is named after its first file. They include by a path from `root`, which has to be
# among the target's include folders: CMake's own units hold the checkout's path, and ccache would take those of another
# clone for other code. Sixteen, as with eight the whole build takes 653 job-seconds where it takes 583.
function(piste_add_files target root folder)
  if(folder STREQUAL "*")
    set(files ${ARGN})
  else()
    list(TRANSFORM ARGN PREPEND ${folder}/ OUTPUT_VARIABLE files)
  endif()
  list(TRANSFORM files APPEND .cpp)
  list(TRANSFORM files PREPEND ${root}/ OUTPUT_VARIABLE sources)
  target_sources(${target} PRIVATE ${sources})
  set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS "${PISTE_SOURCE_OPTIONS}")
  if(NOT PISTE_UNITY)
    return()
  endif()
  set_source_files_properties(${sources} PROPERTIES HEADER_FILE_ONLY ON)
  list(LENGTH files left)
  while(left GREATER 0)
    list(SUBLIST files 0 16 together)
    list(GET together 0 first)
    list(REMOVE_ITEM files ${together})
    list(LENGTH files left)
    list(TRANSFORM together REPLACE "(.+)" "#include \"\\1\"\n")
    list(JOIN together "" content)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/unity/${target}/${first})
    file(CONFIGURE OUTPUT ${source} CONTENT "${content}" @ONLY)
    target_sources(${target} PRIVATE ${source})
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "${PISTE_SOURCE_OPTIONS}")
  endwhile()
endfunction()
