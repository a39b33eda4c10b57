// A 3x3 matrix as numpy.save() writes it.
#include <bit>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "pipeline/readers/cameras/calibration_formats.h"

namespace hexrelief::codec {
namespace {

std::uint64_t little_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(bytes[i])) << (8 * i);
    return value;
}

}  // namespace

bool is_npy(std::string_view bytes) {
    return bytes.starts_with("\x93NUMPY");
}

std::string text_of_npy(const CalibrationText& source, std::string_view bytes) {
    constexpr std::size_t before_header = 10;
    const bool has_header = bytes.size() >= before_header && bytes[6] == 1;
    const std::size_t header_bytes = has_header ? little_endian(bytes.substr(8, 2)) : 0;
    if (!has_header || bytes.size() < before_header + header_bytes)
        refuse_key(source, "the NPY file",
                   "is truncated, or not of version 1.0; save it again by numpy.save()");
    const std::string_view header = bytes.substr(before_header, header_bytes),
                           data = bytes.substr(before_header + header_bytes);
    const auto has = [&](std::string_view part) { return header.find(part) != std::string_view::npos; };
    const bool is_double = has("'<f8'"), is_float = has("'<f4'");
    if (!has("'shape': (3, 3)") || !(is_double || is_float))
        refuse_key(source, "the NPY file", "must hold a 3x3 array of float64 or float32, K");
    const std::size_t size = is_double ? 8 : 4;
    if (data.size() != 9 * size) refuse_key(source, "the NPY file", "must hold nine numbers, and does not");
    // By columns or by rows: parse_matrix() tells them apart.
    std::string text;
    for (std::size_t i = 0; i < 9; ++i) {
        const std::uint64_t bits = little_endian(data.substr(i * size, size));
        char number[40];
        std::snprintf(number, sizeof number, "%.17g ",
                      is_double
                          ? std::bit_cast<double>(bits)
                          : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
        text += number;
    }
    return text;
}

}  // namespace hexrelief::codec
