# Writes a CTest file with one test for each suite of a GoogleTest program: a process a test would spend
# three quarters of the time on loading PETSc's libraries.
# cmake -DPROGRAM=bipot_tests -DOUTPUT=suites.cmake -P suites.cmake
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE list
  COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[;#][^\n]*" "" list "${list}")
string(REPLACE "\n" ";" lines "${list}")
set(text "")
foreach(line IN LISTS lines)
  # A suite begins its line and ends in a dot; its tests are indented.
  if(line MATCHES "^([A-Za-z_][A-Za-z0-9_/]*)\\. *$")
    set(suite "${CMAKE_MATCH_1}")  # before the next comparison forgets it
    if(suite STREQUAL "")
      message(FATAL_ERROR "a suite without a name: its filter would select nothing, and pass")
    endif()
    if(suite STREQUAL "ShippedProblems")
      continue()
    endif()
    string(APPEND text
      "add_test([==[${suite}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${suite}.*]==])\n")
    if(suite MATCHES "EveryRow$")  # bounds in seconds: nothing may run beside it
      string(APPEND text "set_tests_properties([==[${suite}]==] PROPERTIES RUN_SERIAL ON)\n")
    endif()
    if(suite STREQUAL "Newton")  # whole stacks, by which tests/leaks.supp knows a leak of PETSc's
      string(APPEND text "set_tests_properties([==[${suite}]==] PROPERTIES ENVIRONMENT "
        "ASAN_OPTIONS=fast_unwind_on_malloc=0)\n")
    endif()
  endif()
endforeach()
if(text STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} lists no suite")
endif()
file(WRITE ${OUTPUT} "${text}")
