# Is every source as clang-format 14 (Debian 12) leaves it? cmake -DROOT= -DCLANG_FORMAT= -P format.cmake
cmake_minimum_required(VERSION 3.25)

set(version "")
if(CLANG_FORMAT)
  execute_process(COMMAND ${CLANG_FORMAT} --version OUTPUT_VARIABLE version)
endif()
if(NOT version MATCHES "version 14\\.")
  message("clang-format 14 is not installed: formatting was not checked")
  return()
endif()
file(GLOB_RECURSE sources ${ROOT}/core/*.h ${ROOT}/core/*.cc ${ROOT}/solvers/*.h
  ${ROOT}/solvers/*.cc ${ROOT}/bench/*.h ${ROOT}/bench/*.cc ${ROOT}/tests/*.h ${ROOT}/tests/*.cc)
execute_process(COMMAND ${CLANG_FORMAT} --dry-run -Werror --style=file ${sources}
  RESULT_VARIABLE result ERROR_VARIABLE complaints)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${complaints}")
endif()
