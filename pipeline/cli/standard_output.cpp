#include "pipeline/cli/standard_output.h"

#include <unistd.h>

#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"

namespace hexrelief::cli {

void refuse_terminal(const std::vector<std::string>& outputs) {
    for (const std::string& output : outputs)
        if (files::is_standard_output(output) && isatty(STDOUT_FILENO))
            throw Error(ErrorKind::usage,
                        "-o " + output +
                            ": the standard output is a terminal, which cannot show a mesh; "
                            "redirect it, as in '-o - > relief.glb'");
}

}  // namespace hexrelief::cli
