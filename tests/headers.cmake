# Every public header compiles alone, and twice: one translation unit each, found by a glob so that none is forgotten. Not
# optimised, as there is nothing in them but what the compiler has to read; and only when asked: the target `headers`.
file(GLOB_RECURSE _headers RELATIVE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/include/piste/*.h)
add_library(headers OBJECT EXCLUDE_FROM_ALL)
foreach(header IN LISTS _headers)
  string(REGEX REPLACE "[/.]" "_" name ${header})
  set(unit ${CMAKE_CURRENT_BINARY_DIR}/headers/${name}.cpp)
  file(CONFIGURE OUTPUT ${unit} CONTENT "#include \"${header}\"\n#include \"${header}\"  // again: it is guarded\n")
  target_sources(headers PRIVATE ${unit})
endforeach()
target_link_libraries(headers PRIVATE piste::piste piste_build)
target_compile_options(headers PRIVATE -O0)
