#include <array>
#include <string_view>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {
namespace {

// Decodes base64 up to the first character that is not a base64 digit.
std::vector<std::uint8_t> from_base64(std::string_view text) {
    static constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<int, 256> values;
    values.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i)
        values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    std::vector<std::uint8_t> bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = values[static_cast<unsigned char>(c)];
        if (value < 0) break;
        bits = (bits << 6) | static_cast<std::uint32_t>(value);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<std::uint8_t>(bits >> count));
    }
    return bytes;
}

}  // namespace

MeshDescription describe_html(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    static constexpr std::string_view kBefore = R"(id="glb">)";
    const std::string_view page(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t at = page.find(kBefore);
    if (at == std::string_view::npos)
        fail_reading(path, "it is no page with a mesh that hexrelief has written");
    const std::vector<std::uint8_t> glb = from_base64(page.substr(at + kBefore.size()));
    if (glb.empty()) fail_reading(path, "the page holds no mesh");
    return describe_gltf(path, glb, glb.size(), true);
}

}  // namespace hexrelief::inspect
