#include "pipeline/stages/wls_filter.h"

#include <dlfcn.h>

#include <array>
#include <filesystem>
#include <string>

#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

WlsFunction load() {
    std::error_code failure;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failure);
    const std::filesystem::path folder = program.parent_path();
    // The last two are for programs that are built into folders below the build root, as the tests are.
    const std::array candidates = {folder, folder / "../lib/hexrelief", folder / "../lib", folder / "..",
                                   folder / "../.."};
    for (const std::filesystem::path& candidate : candidates) {
        const std::filesystem::path path = (candidate / kWlsLibraryName).lexically_normal();
        if (!std::filesystem::exists(path, failure)) continue;
        void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (library == nullptr) {
            throw Error(ErrorKind::usage, "disparity.wls: " + std::string(dlerror()) +
                                              "; install OpenCV's ximgproc or "
                                              "leave disparity.wls off");
        }
        if (void* const symbol = dlsym(library, kWlsFunctionName))
            return reinterpret_cast<WlsFunction>(symbol);
        throw Error(ErrorKind::usage,
                    "disparity.wls: " + path.string() + " is not hexrelief's filter; reinstall it");
    }
    throw Error(ErrorKind::usage,
                "disparity.wls: " + std::string(kWlsLibraryName) + " is not in " + folder.string() +
                    " nor in ../lib/hexrelief; build with OpenCV's ximgproc installed or leave "
                    "disparity.wls off");
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
