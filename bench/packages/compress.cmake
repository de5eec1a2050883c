# Debian's documents are compressed. (A name and a time in them would differ from build to build.)
foreach(text doc/bipot/changelog man/man1/bipot.1)
  execute_process(COMMAND gzip -9n ${CPACK_TEMPORARY_DIRECTORY}/usr/share/${text}
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()
