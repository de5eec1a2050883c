# The fence: which folder may include which. cmake -DROOT=<tree> -P folders.cmake
#
# A folder may include itself, the folders of its row, and what those may include. Arrows go down
# only: the table is read from top to bottom, and a row may name only folders above it. The table of
# solvers (solvers/methods/solver_table.cc) has no header, so that nobody includes it.
#
# And a type has one header: two of one name would be two definitions of it for the linker. No time
# limit follows a clock that can be set, and no number is read by the rules of a locale.
cmake_minimum_required(VERSION 3.25)

set(folders
  "core ="
  "core/base = core"
  "core/linear = core/base"
  "core/problem = core/linear"
  "core/criterion = core/problem"
  "core/scene = core/base"
  "core/motion = core/criterion core/scene"
  "core/observables = core/motion"
  "core/files = core/base"
  "core/problem_files = core/files core/motion"
  "core/scene_files = core/files core/scene"
  "core/run_files = core/files core/observables core/problem_files"
  "core/pictures = core/files core/motion"
  "solvers = core/criterion"
  "solvers/analysis = solvers core/scene"
  "solvers/kernels = solvers"
  "solvers/disks = solvers/kernels"
  "solvers/systems = solvers"
  "solvers/petsc = solvers/kernels"
  "solvers/parallel = solvers/disks solvers/petsc"
  "solvers/auto = solvers/kernels"
  "solvers/interior = solvers/kernels solvers/systems"
  "solvers/homotopy = solvers/kernels solvers/systems"
  "solvers/methods = solvers/analysis solvers/auto solvers/homotopy solvers/interior solvers/parallel"
  "solvers/simulation = core/pictures core/run_files solvers/methods"
  "bench/report = core/files solvers/analysis"
  "bench/page = bench/report core/pictures core/run_files core/scene_files"
  "bench/problems = bench/report core/scene_files solvers/simulation"
  "bench/measure = bench/problems"
  "bench/tradeoff = bench/measure"
  "bench/compare = bench/measure"
  "bench/tune = bench/measure"
  "bench/experiments = bench/measure"
  "bench/study = bench/experiments bench/tradeoff"
  "bench/command = bench/compare bench/page bench/study bench/tune"
  "bench/programs = bench/command"
  "bench/python = bench/compare bench/tradeoff"
  "tests = bench/programs bench/python")

set(known "")
foreach(row IN LISTS folders)
  string(REGEX MATCH "^([a-z_/]+) =(.*)$" _ "${row}")
  set(folder "${CMAKE_MATCH_1}")
  string(STRIP "${CMAKE_MATCH_2}" named)
  separate_arguments(named)
  set(reach_${folder} ${folder})
  foreach(lower IN LISTS named)
    if(NOT lower IN_LIST known)
      message(FATAL_ERROR "the table: ${folder} names ${lower}, which does not stand above it")
    endif()
    list(APPEND reach_${folder} ${reach_${lower}})
  endforeach()
  list(APPEND known ${folder})
endforeach()

set(bad 0)
set(arrows 0)
set(types "")
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/core/*.h ${ROOT}/core/*.cc ${ROOT}/solvers/*.h
  ${ROOT}/solvers/*.cc ${ROOT}/bench/*.h ${ROOT}/bench/*.cc ${ROOT}/tests/*.h ${ROOT}/tests/*.cc)
foreach(source IN LISTS sources)
  get_filename_component(folder ${source} DIRECTORY)
  string(REGEX REPLACE "^tests/.*" "tests" folder ${folder})
  if(NOT folder IN_LIST known)
    message("${source}: the folder ${folder} is not in the table")
    math(EXPR bad "${bad} + 1")
    continue()
  endif()
  if(source MATCHES "\\.h$")
    file(STRINGS ${ROOT}/${source} lines REGEX "^(struct|class|enum class) [A-Za-z0-9]+ .*{")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^(struct|enum class|class) ([A-Za-z0-9]+) .*" "\\2" type "${line}")
      if(type IN_LIST types)
        message("${source}: ${type} has a header already: ${header_of_${type}}")
        math(EXPR bad "${bad} + 1")
      endif()
      list(APPEND types ${type})
      set(header_of_${type} ${source})
    endforeach()
  endif()
  if(NOT folder STREQUAL "tests")
    file(STRINGS ${ROOT}/${source} lines
      REGEX "system_clock|gettimeofday|[^a-z_](strtod|strtof|atof|stod|stof|sscanf)\\(")
    foreach(line IN LISTS lines)
      message("${source}: follows a clock that jumps or the locale: ${line}")
      math(EXPR bad "${bad} + 1")
    endforeach()
  endif()
  file(STRINGS ${ROOT}/${source} lines REGEX "^#include \"(core|solvers|bench|tests)/")
  foreach(line IN LISTS lines)
    string(REGEX MATCH "\"([^\"]+)/[^/\"]+\"" _ "${line}")
    string(REGEX REPLACE "^tests/.*" "tests" target ${CMAKE_MATCH_1})
    math(EXPR arrows "${arrows} + 1")
    if(NOT target IN_LIST reach_${folder})
      message("${source}: ${folder} may not include ${target}: ${line}")
      math(EXPR bad "${bad} + 1")
    endif()
  endforeach()
endforeach()
if(bad)
  message(FATAL_ERROR "${bad} arrows against the table of tests/folders.cmake, types with two headers, clocks or locales")
endif()
if(NOT arrows)
  message(FATAL_ERROR "no include found below ${ROOT}")
endif()
message("${arrows} includes, all along the table")
