#include "pipeline/stages/wls_filter.h"

#include <dlfcn.h>

#include <array>
#include <filesystem>
#include <string>

#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

// The program's, and the one of the shared library that this may be a part of.
std::array<fs::path, 2> own_folders() {
    std::error_code failure;
    const fs::path program = fs::read_symlink("/proc/self/exe", failure).parent_path();
    Dl_info own{};
    if (dladdr(kWlsLibraryName, &own) == 0 || own.dli_fname == nullptr || *own.dli_fname != '/')
        return {program, program};
    return {program, fs::path(own.dli_fname).parent_path()};
}

fs::path find_library() {
    const std::array folders = own_folders();
    // The last two are for programs that are built into folders below the build root, as the tests are.
    for (const fs::path& folder : folders)
        for (const char* const place : {"", "../lib/hexrelief", "../lib", "../hexrelief", "hexrelief",
                                        "../../../hexrelief", "..", "../.."}) {
            std::error_code failure;
            const fs::path path = (folder / place / kWlsLibraryName).lexically_normal();
            if (fs::exists(path, failure)) return path;
        }
    throw Error(ErrorKind::usage,
                "disparity.wls: " + std::string(kWlsLibraryName) + " is not in " + folders[0].string() +
                    " nor in ../lib/hexrelief; build with OpenCV's ximgproc installed or leave "
                    "disparity.wls off");
}

WlsFunction load() {
    const fs::path path = find_library();
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        throw Error(ErrorKind::usage, "disparity.wls: " + std::string(dlerror()) +
                                          "; install OpenCV's ximgproc or "
                                          "leave disparity.wls off");
    }
    if (void* const symbol = dlsym(library, kWlsFunctionName)) return reinterpret_cast<WlsFunction>(symbol);
    throw Error(ErrorKind::usage,
                "disparity.wls: " + path.string() + " is not hexrelief's filter; reinstall it");
}

}  // namespace

void filter_wls(const WlsRequest& request) {
    static const WlsFunction run = load();
    std::array<char, 512> message{};
    WlsRequest call = request;
    call.message = message.data();
    call.message_bytes = static_cast<int>(message.size());
    if (run(&call) != 0) throw Error(ErrorKind::usage, "disparity.wls: " + std::string(message.data()));
}

}  // namespace hexrelief
