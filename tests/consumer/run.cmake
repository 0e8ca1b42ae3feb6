# Installs piste from BUILD_DIR into a prefix of its own below WORK_DIR, then configures, builds and runs the consumers:
# two link with piste::piste, one with piste::batch.
include(${CMAKE_CURRENT_LIST_DIR}/../step.cmake)

# Every header that a front door exports must stand in the program that links with it.
function(covered door program)
  file(READ ${WORK_DIR}/prefix/include/piste/${door} exported)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/${program} text)
  string(REGEX MATCHALL "#include \"piste/[^\"]+\"" includes "${exported}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "#include \"(.+)\"" "\\1" header ${include})
    string(FIND "${text}" "${header}" place)
    if(place EQUAL -1)
      message(FATAL_ERROR "${door} exports ${include}, of which ${program} uses nothing")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
step(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
covered(piste.h main.cpp)
covered(batch.h batch.cpp)
step(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
step(${WORK_DIR}/build/consumer)
step(${WORK_DIR}/build/consumer_batch)
step(${WORK_DIR}/build/logger)
