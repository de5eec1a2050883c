// Under the leak checker the modules that MPI loads stay loaded: what they leave behind then has a
// library's name, which tests/leaks.supp can tell from what Bipot would leave.
extern "C" __attribute__((visibility("default"))) int dlclose(void*) { return 0; }
