#include "pipeline/cli/tiles/command_tiles.h"

#include "pipeline/cli/tiles/tiles_commands.h"

namespace hexrelief::cli {

void add_tiles_command(Command& program) {
    Command group =
        program.add_command("tiles", "maps that do not fit into memory, on any number of machines");
    group.set_footer(
        "Example:\n"
        "  hexrelief tiles plan map.tif -o relief\n"
        "  hexrelief tiles solve relief\n"
        "  hexrelief tiles merge relief -o relief/tileset.json");
    add_match_command(group);
    add_plan_command(group);
    add_solve_command(group);
    add_merge_command(group);
}

}  // namespace hexrelief::cli
