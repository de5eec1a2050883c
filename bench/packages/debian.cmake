# cpack -G DEB: one package for the Debian or Ubuntu that it is built on. The libraries that it
# depends on, with their versions, are read from its programs (dpkg-shlibdeps).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME bipot)
set(CPACK_PACKAGE_VENDOR "the Bipot developers")
set(CPACK_PACKAGE_CONTACT "the Bipot developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Frictional contact of rigid disks and spheres: solvers and simulation")
set(CPACK_PACKAGE_DESCRIPTION "Bipot runs scenes of rigid grains, solves single contact problems with many
solvers, and measures how wrong an answer is. It has a command, a C++ library
and a Python module.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/bench/packages/compress.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libopenblas0-serial, gnuplot-nox")
# What find_package(bipot) asks for; for bipot movie and several processes, ffmpeg and openmpi-bin.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "cmake, coinor-libclp-dev, ffmpeg, libcairo2-dev, libeigen3-dev, libfmt-dev, libhdf5-dev, libpetsc-real-dev, libsuitesparse-dev, libtomlplusplus-dev, openmpi-bin, pkg-config")
set(components program library)
set(debian_python /usr/bin/python3)
set(debian_module ${BIPOT_WITH_PYTHON})
if(debian_module)
  file(REAL_PATH ${debian_python} debian_python)
  file(REAL_PATH ${BIPOT_PYTHON} module_python)
  if(NOT module_python STREQUAL debian_python)
    message(STATUS "cpack -G DEB leaves the Python module out: it is for ${BIPOT_PYTHON}, not Debian's")
    set(debian_module OFF)
  endif()
endif()
if(debian_module)
  # Debian's Python looks for packages in another folder below /usr than below /usr/local.
  list(APPEND components debian_python)
  execute_process(COMMAND ${BIPOT_PYTHON} -c "import sys; v = sys.version_info
print(f'python3 (>= {v[0]}.{v[1]}), python3 (<< {v[0]}.{v[1] + 1}), python3-numpy, python3-scipy')"
    OUTPUT_VARIABLE CPACK_DEBIAN_PACKAGE_DEPENDS OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(APPEND CPACK_DEBIAN_PACKAGE_RECOMMENDS ", python3-matplotlib")
  set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${CMAKE_SOURCE_DIR}/bench/packages/postinst ${CMAKE_SOURCE_DIR}/bench/packages/prerm)
endif()
foreach(component IN LISTS components)
  list(APPEND CPACK_INSTALL_CMAKE_PROJECTS ${CMAKE_BINARY_DIR} bipot ${component} /)
endforeach()
include(CPack)
