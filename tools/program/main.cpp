#include "tools/commands/program.h"

int main(int argc, char** argv) { return palpate::tools::commands::run_program(argc, argv); }
