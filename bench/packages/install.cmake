# What is installed, in three components:
#   program  the command, its scenes, manual page, completions, copyright, changes
#   library  libraries, headers, what find_package(bipot) reads
#   python   the module (bench/python/CMakeLists.txt)
include(CMakePackageConfigHelpers)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # a package does not need the tests
set(bin bin)
set(share share)
if(SKBUILD)  # a wheel, whose prefix is the folder of Python packages (pyproject.toml)
  set(bin ${SKBUILD_SCRIPTS_DIR})
  set(share ${SKBUILD_DATA_DIR}/share)
endif()
install(TARGETS bipot RUNTIME DESTINATION ${bin} COMPONENT program)
install(DIRECTORY data/ DESTINATION ${share}/bipot COMPONENT program
  PATTERN collection EXCLUDE PATTERN study EXCLUDE PATTERN fuzz EXCLUDE
  REGEX "/make_[^/]*$" EXCLUDE)
foreach(folder collection fuzz)  # the manual shows these
  install(FILES data/${folder}/README.md DESTINATION ${share}/bipot/${folder} COMPONENT program)
endforeach()
install(DIRECTORY data/study DESTINATION ${share}/bipot COMPONENT program
  FILES_MATCHING PATTERN *.md PATTERN *.svg)
# The command writes its own manual page and the completion of shells, from what it declares.
set(pages ${CMAKE_BINARY_DIR}/generated_pages)
file(MAKE_DIRECTORY ${pages})
foreach(page "help --man|bipot.1|man/man1"
    "completion bash|bipot|bash-completion/completions"
    "completion zsh|_bipot|zsh/site-functions"
    "completion fish|bipot.fish|fish/vendor_completions.d")
  string(REPLACE "|" ";" parts "${page}")
  list(GET parts 0 question)
  list(GET parts 1 file)
  list(GET parts 2 folder)
  string(REPLACE " " "\" \"" question "${question}")
  install(CODE "execute_process(COMMAND \"$<TARGET_FILE:bipot>\" \"${question}\"
    OUTPUT_FILE \"${pages}/${file}\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
  install(FILES ${pages}/${file} DESTINATION ${share}/${folder} COMPONENT program)
endforeach()
# Who holds which rights: of the program, and of what stands in its pages or is linked with it.
file(READ bench/page/uplot/LICENSE uplot_licence)
file(READ bench/packages/notices.txt notices)
if(BIPOT_WITH_GPL)
  file(READ bench/packages/gpl_note.txt gpl_note)
  if(BIPOT_WITH_CLP)
    string(APPEND gpl_note "
It is linked with CLP as well, under the Eclipse Public License 1.0, which the GNU licence does not
admit beside it. Such a binary may be used, but not passed on. One to be passed on is configured with
-DBIPOT_WITH_CLP=OFF, or without those parts of SuiteSparse by -DBIPOT_WITH_GPL=OFF.
")
  endif()
elseif(BIPOT_WITH_CLP)
  set(gpl_note "\nThis build is linked with CLP, which is under the Eclipse Public License 1.0.\n")
endif()
configure_file(bench/packages/copyright.in ${pages}/copyright @ONLY)
install(FILES ${pages}/copyright DESTINATION ${share}/doc/bipot COMPONENT program)
install(FILES CHANGELOG.md DESTINATION ${share}/doc/bipot RENAME changelog COMPONENT program)

install(TARGETS bipot_options bipot_core bipot_solvers EXPORT bipot
  ARCHIVE DESTINATION lib COMPONENT library)
install(EXPORT bipot NAMESPACE bipot:: DESTINATION lib/cmake/bipot FILE bipot-targets.cmake
  COMPONENT library)
# Closed: they include no other header of the project (tests/install.cmake). At most 20.
foreach(header
    core/base/execution.h core/base/file_error.h core/base/types.h
    core/criterion/contact_error.h core/criterion/impulse_verdict.h
    core/motion/state.h core/motion/time_stepping.h
    core/problem/contact_problem.h core/problem_files/problem_file.h
    core/scene/cell.h core/scene/contact.h core/scene/contact_frame.h core/scene/gates.h
    core/scene/observable_choice.h core/scene/scene.h core/scene_files/scene_file.h
    solvers/registry.h solvers/solve.h solvers/solver.h solvers/simulation/scene_run.h)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION include/bipot/${folder} COMPONENT library)
endforeach()
configure_package_config_file(solvers/bipot-config.cmake.in bipot-config.cmake
  INSTALL_DESTINATION lib/cmake/bipot)
write_basic_package_version_file(bipot-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/bipot-config.cmake ${CMAKE_BINARY_DIR}/bipot-config-version.cmake
  DESTINATION lib/cmake/bipot COMPONENT library)
