#include "pipeline/files/output_set.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>

#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/sha256.h"

namespace hexrelief::files {
namespace {

namespace fs = std::filesystem;

// Folders made by this process and not yet kept, and how many sets need each of them.
std::mutex folders_mutex;
std::map<fs::path, int> fresh_folders;

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
    throw Error(ErrorKind::output, "cannot write " + path.string() + ": " + why);
}

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

bool is_standard_output(const fs::path& path) {
    return path.stem() == "-" && !path.has_parent_path();
}

void check_writable_file(const fs::path& path) {
    std::error_code code;
    const fs::path folder = folder_of(path);
    if (path.filename().empty() || fs::is_directory(path, code))
        fail(path, "it is a folder; give a file name");
    check_writable_folder(folder);
    if (fs::exists(path, code) && access(path.c_str(), W_OK) != 0) fail(path, std::strerror(errno));
}

void check_writable_folder(const fs::path& folder) {
    std::error_code code;
    fs::path existing = folder;
    while (!fs::exists(existing, code) && existing.has_relative_path()) existing = folder_of(existing);
    if (!fs::is_directory(existing, code)) fail(folder, existing.string() + " is not a folder");
    if (access(existing.c_str(), W_OK) != 0)
        fail(folder, "the folder " + existing.string() + ": " + std::strerror(errno));
}

bool FileIdentity::operator==(const FileIdentity& other) const {
    return path == other.path || (node != 0 && node == other.node && device == other.device);
}

FileIdentity identify(const fs::path& path) {
    std::error_code code;
    fs::path target = fs::absolute(path, code);
    // A link whose target does not exist yet: the target will be made.
    for (int links = 0; links < 40 && fs::is_symlink(target, code) && !fs::exists(target, code); ++links)
        target = target.parent_path() / fs::read_symlink(target, code);
    FileIdentity identity{fs::weakly_canonical(target, code), 0, 0};
    if (code) identity.path = target.lexically_normal();  // in a folder that may not be looked into
    struct stat status {};
    if (stat(target.c_str(), &status) == 0) {
        identity.device = status.st_dev;
        identity.node = status.st_ino;
    }
    return identity;
}

void check_overwrites(const std::vector<fs::path>& written, const std::vector<fs::path>& read) {
    for (const fs::path& output : written) {
        if (output.empty()) continue;
        const FileIdentity identity = identify(output);
        for (const fs::path& input : read)
            if (!input.empty() && identity == identify(input))
                throw Error(ErrorKind::usage, output.string() + " would overwrite the input " +
                                                  input.string() + "; choose another name");
    }
}

OutputSet::OutputSet()
    : files_([this](const fs::path& path, const void* data, std::size_t bytes) {
          written_.push_back({is_standard_output(path) ? "-" : path, bytes, sha256_of(data, bytes)});
      }) {}

OutputSet::FreshFolders::~FreshFolders() {
    const std::lock_guard lock(folders_mutex);
    std::error_code ignored;
    for (auto folder = paths.rbegin(); folder != paths.rend(); ++folder) {
        const auto fresh = fresh_folders.find(*folder);
        if (fresh == fresh_folders.end() || --fresh->second > 0) continue;
        fs::remove(*folder, ignored);
        fresh_folders.erase(fresh);
    }
}

void OutputSet::make_folder(const fs::path& folder) {
    wait_if_interrupted();
    const std::lock_guard lock(folders_mutex);
    std::error_code code;
    std::vector<fs::path> needed;
    for (fs::path at = folder; !at.empty() && (fresh_folders.contains(at) || !fs::exists(at, code));
         at = at.parent_path())
        needed.push_back(at);
    for (auto at = needed.rbegin(); at != needed.rend(); ++at) {
        if (fs::create_directory(*at, code) || fresh_folders.contains(*at)) {
            ++fresh_folders[*at];
            folders_.paths.push_back(*at);
        }
        if (code) fail(*at, code.message());
    }
}

void OutputSet::place(const fs::path& path) {
    if (is_standard_output(path))
        files_.send_to_standard_output(path);
    else
        make_folder(folder_of(path));
}

void OutputSet::commit() {
    files_.commit();
    const std::lock_guard lock(folders_mutex);
    for (const fs::path& folder : folders_.paths) fresh_folders.erase(folder);
    folders_.paths.clear();
}

void roll_back_outputs() {
    exporters::remove_pending_files();
    const std::lock_guard lock(folders_mutex);
    std::error_code ignored;
    // In reverse order, so that folders inside others are removed first.
    for (auto folder = fresh_folders.rbegin(); folder != fresh_folders.rend(); ++folder)
        fs::remove(folder->first, ignored);
    fresh_folders.clear();
}

}  // namespace hexrelief::files
