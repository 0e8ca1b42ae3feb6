# Writes LIST, the ctest tests of a program of GoogleTest: each is named after its file and has that file's label.
# PROGRAM: its command, with an emulator where it is of another processor.
# cmake -D PROGRAM=… -D LABELS="FOLDER/FILE=LABEL;…" -D LIST=… -P list_tests.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests --gtest_output=json:${LIST}.json OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
list(JOIN PROGRAM " " command)
file(READ ${LIST}.json json)
string(JSON suites GET ${json} testsuites)
string(JSON last_suite LENGTH ${suites})
math(EXPR last_suite "${last_suite} - 1")
set(out "")
foreach(i RANGE ${last_suite})
  string(JSON suite GET ${suites} ${i})
  string(JSON suite_name GET ${suite} name)
  string(JSON last LENGTH ${suite} testsuite)
  math(EXPR last "${last} - 1")
  foreach(j RANGE ${last})
    string(JSON name GET ${suite} testsuite ${j} name)
    string(JSON file GET ${suite} testsuite ${j} file)
    string(REGEX REPLACE ".*/([^/]+/[^/]+)\\.cpp$" "\\1" file ${file})
    string(REGEX MATCH "(^|;)${file}=([a-z]+)" label "${LABELS}")
    string(APPEND out "add_test([==[${file}.${suite_name}.${name}]==] ${command} --gtest_filter=${suite_name}.${name} "
      "--gtest_also_run_disabled_tests)\n"
      "set_tests_properties([==[${file}.${suite_name}.${name}]==] PROPERTIES LABELS ${CMAKE_MATCH_2} "
      "SKIP_REGULAR_EXPRESSION [==[\\[  SKIPPED \\]]==])\n")
  endforeach()
endforeach()
file(WRITE ${LIST} "${out}")
