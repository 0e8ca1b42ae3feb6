# With CMAKE_UNITY_BUILD, up to sixteen neighbours of a folder are compiled as one unit, as most of a file's time goes into
# headers and templates that its neighbours need too. Units stay within `name`, so that a new file changes none elsewhere. The
# target needs UNITY_BUILD_MODE GROUP.
function(piste_unity name)
  set(number 0)
  foreach(file IN LISTS ARGN)
    math(EXPR unit "${number} / 16")
    set_source_files_properties(${file} PROPERTIES UNITY_GROUP ${name}_${unit})
    math(EXPR number "${number} + 1")
  endforeach()
endfunction()
