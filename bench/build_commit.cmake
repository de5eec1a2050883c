cmake_minimum_required(VERSION 3.25)
# Writes OUTPUT with the commit of SOURCE, "-dirty" where tracked files differ; touches the file only
# when that changes. "unknown" outside a repository.
execute_process(COMMAND git describe --always --abbrev=12 --dirty --exclude=*
  WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
  ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once\n\n#define BIPOT_COMMIT \"@commit@\"\n" @ONLY)
