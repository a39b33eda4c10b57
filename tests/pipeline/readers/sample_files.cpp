#include "tests/pipeline/readers/sample_files.h"

#include <png.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <webp/encode.h>

#include <bit>
#include <cstring>
#include <fstream>

#include "tests/libjpeg.h"

namespace hexrelief::readers {

std::filesystem::path Folder::write(const std::string& name, const Bytes& bytes) const {
    // A new file each time, because some file systems flush to disk when a truncated file is closed.
    std::filesystem::remove(path() / name);
    std::ofstream file(path() / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw std::runtime_error("cannot write " + name);
    return path() / name;
}

std::filesystem::path Folder::write(const std::string& name, std::string_view text) const {
    return write(name, to_bytes(text));
}

Bytes read_bytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(file), {});
}

Bytes to_bytes(std::string_view text) {
    return Bytes(text.begin(), text.end());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

Bytes operator+(Bytes left, const Bytes& right) {
    left.insert(left.end(), right.begin(), right.end());
    return left;
}

Bytes make_png(int width, int height, const Bytes& rows, const PngKind& kind) {
    Bytes out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &out,
        [](png_structp self, png_bytep data, size_t count) {
            auto* to = static_cast<Bytes*>(png_get_io_ptr(self));
            to->insert(to->end(), data, data + count);
        },
        nullptr);
    png_set_IHDR(png, info, width, height, kind.bits, kind.colour_type,
                 kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (!kind.palette.empty()) {
        std::vector<png_color> palette(kind.palette.size() / 3);
        std::memcpy(palette.data(), kind.palette.data(), kind.palette.size());
        png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
    }
    if (!kind.palette_alpha.empty()) {
        png_set_tRNS(png, info, kind.palette_alpha.data(), static_cast<int>(kind.palette_alpha.size()),
                     nullptr);
    }
    png_write_info(png, info);
    const std::size_t stride = rows.size() / height;
    std::vector<png_bytep> pointers(height);
    for (int y = 0; y < height; ++y) pointers[y] = const_cast<png_bytep>(rows.data() + y * stride);
    png_write_image(png, pointers.data());
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return out;
}

Bytes make_jpeg(int width, int height, const Bytes& samples, JpegKind kind) {
    const int channels = kind == JpegKind::grey ? 1 : kind == JpegKind::cmyk ? 4 : 3;
    return test::encoded_by_libjpeg({width, height, channels, samples}, [&](jpeg_compress_struct& jpeg) {
        jpeg_set_quality(&jpeg, 95, TRUE);
        if (kind == JpegKind::rgb_progressive) jpeg_simple_progression(&jpeg);
    });
}

Bytes make_webp(int width, int height, const Bytes& rgba, bool lossless) {
    std::uint8_t* buffer = nullptr;
    const std::size_t size = lossless ? WebPEncodeLosslessRGBA(rgba.data(), width, height, width * 4, &buffer)
                                      : WebPEncodeRGBA(rgba.data(), width, height, width * 4, 90, &buffer);
    Bytes out(buffer, buffer + size);
    WebPFree(buffer);
    return out;
}

Bytes make_pgm(int width, int height, int max_value, const Bytes& samples, char kind) {
    return to_bytes(std::string("P") + kind + "\n" + std::to_string(width) + " " + std::to_string(height) +
                    "\n" + std::to_string(max_value) + "\n") +
           samples;
}

Bytes make_pfm(int width, int height, const std::vector<float>& values, bool little_endian) {
    Bytes samples;
    for (float value : values) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        for (int i = 0; i < 4; ++i)
            samples.push_back(static_cast<std::uint8_t>(bits >> (little_endian ? 8 * i : 24 - 8 * i)));
    }
    return to_bytes("Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n" +
                    (little_endian ? "-0.003922\n" : "0.003922\n")) +
           samples;
}

long peak_memory_MiB(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        try {
            work();
        } catch (const std::exception&) {
            _exit(1);
        }
        _exit(testing::Test::HasFailure() ? 1 : 0);
    }
    int status = 1;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    EXPECT_EQ(status, 0);
    return usage.ru_maxrss >> 10;
}

}  // namespace hexrelief::readers
