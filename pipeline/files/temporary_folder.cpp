#include "pipeline/files/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

#include "pipeline/data/error.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;

std::mutex temporary_mutex;
std::set<fs::path> temporary_folders;

}  // namespace

TemporaryFolder::TemporaryFolder() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code code;
    std::string name = (fs::temp_directory_path(code) / "hexrelief-XXXXXX").string();
    if (code || !mkdtemp(name.data()))
        throw Error(ErrorKind::output, "cannot make the temporary folder " + name + ": " +
                                           std::generic_category().message(code ? code.value() : errno) +
                                           "; TMPDIR names another place");
    path_ = *temporary_folders.insert(name).first;
}

TemporaryFolder::~TemporaryFolder() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    temporary_folders.erase(path_);
}

void remove_temporary_folders() {
    const std::lock_guard lock(temporary_mutex);
    std::error_code ignored;
    for (const fs::path& folder : temporary_folders) fs::remove_all(folder, ignored);
    temporary_folders.clear();
}

}  // namespace hexrelief::files
