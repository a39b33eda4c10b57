#include "pipeline/app/cli.h"

int main(int argc, char** argv) {
    return hexrelief::run_command_line(argc, argv);
}
