#include "pipeline/stages/wls_filter.h"

#include <array>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/data/module.h"

namespace hexrelief::stages {
namespace {

WlsFunction load() {
    const ModuleFunction module = open_module(kWlsLibraryName, kWlsFunctionName);
    if (module.function == nullptr)
        throw Error(ErrorKind::usage, "disparity.wls: " + module.failure +
                                          "; build with OpenCV's ximgproc installed or leave disparity.wls "
                                          "off");
    return reinterpret_cast<WlsFunction>(module.function);
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

}  // namespace hexrelief::stages
