#include "exporters/viewer/html_text.h"

#include <cctype>
#include <stdexcept>

namespace hexrelief::exporters {

std::string base64(const std::vector<std::uint8_t>& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t three = (std::uint32_t(bytes[i]) << 16) |
                                    (left > 1 ? std::uint32_t(bytes[i + 1]) << 8 : 0u) |
                                    (left > 2 ? std::uint32_t(bytes[i + 2]) : 0u);
        out += kDigits[three >> 18];
        out += kDigits[(three >> 12) & 63];
        out += left > 1 ? kDigits[(three >> 6) & 63] : '=';
        out += left > 2 ? kDigits[three & 63] : '=';
    }
    return out;
}

std::string html_escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string link_to(const std::filesystem::path& path) {
    static constexpr char kHex[] = "0123456789ABCDEF";
    std::string out = "./";  // without it, the first folder's name could look like a URL scheme
    for (const char c : path.generic_string()) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain =
            byte < 128 && (std::isalnum(byte) || std::string_view("-_.~/").find(c) != std::string_view::npos);
        if (plain)
            out += c;
        else
            out += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
    return out;
}

std::string script_escaped(const std::string& json) {
    std::string out;
    for (const char c : json) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

std::string filled(std::string_view page,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values) {
    std::string out;
    for (const auto& [mark, value] : values) {
        const std::size_t at = page.find(mark);
        if (at == std::string_view::npos)
            throw std::logic_error("the viewer's page has no " + std::string(mark));
        out += page.substr(0, at);
        out += value;
        page.remove_prefix(at + mark.size());
    }
    return out += page;
}

}  // namespace hexrelief::exporters
