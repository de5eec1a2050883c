/// Open MPI unloads its plugins at the end without freeing what they allocated; the leak sanitizer
/// then sees leaks in unknown modules, which no suppression can name. Leaks are looked for in builds
/// without MPI (BIPOT_WITH_PETSC=OFF). Read by the address sanitizer, nothing else calls it.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }
