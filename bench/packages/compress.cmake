# Folders are made with the builder's umask: after 077 nobody but root could read the package.
file(CHMOD_RECURSE ${CPACK_TEMPORARY_DIRECTORY}/usr DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE
  OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# Debian's zsh looks for completions of packages elsewhere than below /usr/local.
set(zsh ${CPACK_TEMPORARY_DIRECTORY}/usr/share/zsh)
file(RENAME ${zsh}/site-functions ${zsh}/vendor-completions)
# Debian's documents are compressed. (A name and a time in them would differ from build to build.)
foreach(text doc/bipot/changelog man/man1/bipot.1)
  execute_process(COMMAND gzip -9n ${CPACK_TEMPORARY_DIRECTORY}/usr/share/${text}
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()
