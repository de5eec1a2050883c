// The `bipot` command.

#include "bench/command/bipot_command.h"

int main(int argc, char** argv) { return bipot::bipot_command(argc, argv); }
