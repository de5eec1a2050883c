# Installs the build, builds the programs of tests/consumer against the package alone, and runs them
# and the command. The installed headers are few, and include no other headers of the project.
cmake_minimum_required(VERSION 3.25)

set(prefix ${BUILD}/install_test)
file(REMOVE_RECURSE ${prefix} ${BUILD}/consumer_test ${BUILD}/consumer_without)
set(check COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix}
  OUTPUT_QUIET ${check})

file(GLOB_RECURSE headers RELATIVE ${prefix}/include/bipot ${prefix}/include/bipot/*.h)
list(LENGTH headers count)
if(count EQUAL 0 OR count GREATER 20)
  message(FATAL_ERROR "${count} headers are installed, not 1 to 20: ${headers}")
endif()
foreach(header IN LISTS headers)
  file(STRINGS ${prefix}/include/bipot/${header} includes REGEX "^#include \"")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${include}")
    if(NOT included IN_LIST headers)
      message(FATAL_ERROR "${header} includes ${included}, which is not installed")
    endif()
  endforeach()
endforeach()

execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${BUILD}/consumer_test -G Ninja
  -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${FLAGS} ${check})
execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_LIBDIR=${BUILD} PKG_CONFIG_PATH= ${CMAKE_COMMAND}
  -S ${SOURCE}/consumer -B ${BUILD}/consumer_without -G Ninja -DCMAKE_PREFIX_PATH=${prefix}
  -DCMAKE_CXX_COMPILER=${CXX} OUTPUT_QUIET ERROR_VARIABLE refused RESULT_VARIABLE failed)
if(NOT failed OR NOT refused MATCHES "pkg-config does not find")
  message(FATAL_ERROR "a missing library is not named: ${refused}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD}/consumer_test ${check})
execute_process(COMMAND ${BUILD}/consumer_test/solve_problem
  ${prefix}/share/bipot/problems/2d_pile_300_mu03.hdf5 ${check})
execute_process(COMMAND ${BUILD}/consumer_test/run_scene
  ${prefix}/share/bipot/scenes/compaction_100.toml ${check})
execute_process(COMMAND ${prefix}/bin/bipot list scenes OUTPUT_VARIABLE scenes ${check})
if(NOT scenes MATCHES "compaction")
  message(FATAL_ERROR "the installed command does not list the installed scenes: ${scenes}")
endif()
foreach(name fuzz/hdf5 make_problems.sh make_collection.py collection/1d_random_02.hdf5)  # of the sources alone
  if(EXISTS ${prefix}/share/bipot/${name})
    message(FATAL_ERROR "${name} is installed")
  endif()
endforeach()
foreach(file man/man1/bipot.1 bash-completion/completions/bipot zsh/site-functions/_bipot
    fish/vendor_completions.d/bipot.fish)
  file(READ ${prefix}/share/${file} text)
  if(NOT text MATCHES "step")
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
find_program(needed dpkg-shlibdeps)
if(needed)
  file(REMOVE_RECURSE ${BUILD}/package_test)
  execute_process(COMMAND sh -c "umask 077; exec \"$@\"" sh ${CMAKE_CPACK_COMMAND} -G DEB
      -B ${BUILD}/package_test
    WORKING_DIRECTORY ${BUILD} OUTPUT_QUIET ${check})
  file(GLOB package ${BUILD}/package_test/*.deb)
  execute_process(COMMAND dpkg-deb -c ${package} OUTPUT_VARIABLE packed ${check})
  if(packed MATCHES "[d-]rw[x-]------")
    message(FATAL_ERROR "parts of the package are for root alone: ${packed}")
  endif()
  foreach(file man/man1/bipot.1.gz doc/bipot/changelog.gz zsh/vendor-completions/_bipot)
    if(NOT packed MATCHES "/share/${file}\n")
      message(FATAL_ERROR "${file} is not in the package: ${packed}")
    endif()
  endforeach()
endif()
execute_process(COMMAND ${prefix}/bin/bipot run sliding_cylinder --steps 5 -q --overwrite ${check})
if(PYTHON)
  set(folder ${BUILD}/install_test_python)  # away from the sources
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${PYTHON_DIR} ${PYTHON} -c
    "import bipot; print(bipot.__file__, bipot.Simulation('sliding_cylinder').advance().converged)"
    WORKING_DIRECTORY ${folder} OUTPUT_VARIABLE said ${check})
  if(NOT said MATCHES "install_test/.*True")
    message(FATAL_ERROR "the installed module does not run an installed scene: ${said}")
  endif()
endif()
