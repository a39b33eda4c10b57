#include "exporters/images/image_writer.h"

#include <png.h>
#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "exporters/core/file_transaction.h"
#include "exporters/images/jpeg_encoder.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

static_assert(std::endian::native == std::endian::little,
              "float maps and meshes are written as they lie in memory");

void check(const Image& image) {
    if (image.width < 1 || image.height < 1 || (image.channels != 1 && image.channels != 3) ||
        image.pixels.size() != static_cast<std::size_t>(image.width) * image.height * image.channels)
        throw std::logic_error("image to encode is empty or inconsistent");
}

struct PngSink {
    std::vector<std::uint8_t>* bytes;
    std::string* message;
};

void png_append(png_structp png, png_bytep data, png_size_t size) {
    std::vector<std::uint8_t>& bytes = *static_cast<PngSink*>(png_get_io_ptr(png))->bytes;
    bytes.insert(bytes.end(), data, data + size);
}

void png_failed(png_structp png, png_const_charp message) {
    *static_cast<PngSink*>(png_get_error_ptr(png))->message = message;
    png_longjmp(png, 1);
}

void png_warned(png_structp, png_const_charp) {}

// Separate from its caller, so that nothing with a destructor lives in the frame that longjmp returns to.
bool run_png(png_structp png, png_infop info, const Image& image) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
                 image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int y = 0; y < image.height; ++y) png_write_row(png, image.at(0, y));
    png_write_end(png, info);
    return true;
}

// The same step for all frequencies, which leaves the least mean square error for its bytes: textures are
// looked at from near as well. libjpeg's tables have larger ones for high frequencies. A block's mean, whose
// unit is an eighth of a level, is at most one level off: smooth skies show no blocks.
void set_quality(jpeg_compress_struct& jpeg, int quality) {
    constexpr unsigned kSteps[] = {35, 50};  // of brightness and of colours, at quality 50
    constexpr UINT16 kMostOfMeans = 16;
    for (int table = 0; table < 2; ++table) {
        std::array<unsigned, DCTSIZE2> steps;
        steps.fill(kSteps[table]);
        jpeg_add_quant_table(&jpeg, table, steps.data(), jpeg_quality_scaling(quality), TRUE);
        UINT16& means = jpeg.quant_tbl_ptrs[table]->quantval[0];
        means = std::min(means, kMostOfMeans);
    }
    for (int i = 0; i < jpeg.num_components; ++i) {  // 4:4:4, no chroma subsampling
        jpeg.comp_info[i].h_samp_factor = 1;
        jpeg.comp_info[i].v_samp_factor = 1;
    }
}

std::size_t row_of_map(int width, int height, const std::vector<float>& values) {
    const std::size_t row = static_cast<std::size_t>(width < 0 ? 0 : width);
    if (width < 1 || height < 1 || values.size() != row * static_cast<std::size_t>(height))
        throw std::logic_error("float map to write is empty or inconsistent");
    return row;
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
    check(image);
    std::vector<std::uint8_t> bytes;
    std::string message = "out of memory";
    PngSink sink{&bytes, &message};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, png_failed, png_warned);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    bool done = false;
    if (info) {
        png_set_write_fn(png, &sink, png_append, nullptr);
        // libpng's own limit of a million px a side protects readers; a writer knows its image.
        png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
        done = run_png(png, info, image);
    }
    png_destroy_write_struct(&png, &info);
    if (!done) throw Error(ErrorKind::output, "cannot encode the image as PNG: " + message);
    return bytes;
}

std::vector<std::uint8_t> encode_jpeg(const Image& image, const PixelRect& part, int quality, int threads) {
    check(image);
    return encode_baseline_jpeg(image, part,
                                {[&](jpeg_compress_struct& jpeg) { set_quality(jpeg, quality); }}, threads);
}

std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality) {
    return encode_jpeg(image, {0, 0, image.width, image.height}, quality, 1);
}

std::vector<std::uint8_t> encode_webp(const Image& image, int quality) {
    check(image);
    const auto refuse = [](const std::string& why) {
        throw Error(ErrorKind::output,
                    "cannot encode the image as WebP: " + why +
                        "; choose JPEG or PNG textures or a smaller export.texture_max_px");
    };
    if (std::max(image.width, image.height) > WEBP_MAX_DIMENSION)
        refuse("it is larger than " + std::to_string(WEBP_MAX_DIMENSION) + " px a side");
    std::vector<std::uint8_t> grey_as_rgb;
    if (image.channels == 1) {
        grey_as_rgb.reserve(image.pixels.size() * 3);
        for (const std::uint8_t value : image.pixels) grey_as_rgb.insert(grey_as_rgb.end(), 3, value);
    }
    const std::uint8_t* rgb = image.channels == 1 ? grey_as_rgb.data() : image.pixels.data();
    std::uint8_t* encoded = nullptr;
    const std::size_t size =
        WebPEncodeRGB(rgb, image.width, image.height, image.width * 3, static_cast<float>(quality), &encoded);
    const std::unique_ptr<std::uint8_t, decltype(&WebPFree)> owner(encoded, &WebPFree);
    if (size == 0) refuse("libwebp gave up");
    return {encoded, encoded + size};
}

std::vector<std::uint8_t> encode_pfm(int width, int height, const std::vector<float>& values) {
    const std::size_t row = row_of_map(width, height, values);
    // The negative sign means little endian; the magnitude is 1 because the values are not scaled.
    const std::string header = "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
    std::vector<std::uint8_t> bytes(header.begin(), header.end());
    bytes.resize(header.size() + values.size() * sizeof(float));
    for (int y = 0; y < height; ++y)
        std::memcpy(bytes.data() + header.size() + row * sizeof(float) * y,
                    values.data() + row * (height - 1 - y), row * sizeof(float));
    return bytes;
}

std::vector<std::uint8_t> encode_exr(int width, int height, const std::vector<float>& values) {
    const std::size_t row_bytes = row_of_map(width, height, values) * sizeof(float);
    std::string bytes;
    const auto put = [&](auto... numbers) {
        (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
    };
    const auto attribute = [&](const char* name, const char* type, auto... numbers) {
        bytes.append(name).append(1, '\0').append(type).append(1, '\0');
        put(static_cast<std::int32_t>((0 + ... + sizeof numbers)), numbers...);
    };
    constexpr std::int32_t kMagic = 20000630, kVersion = 2, kFloat = 2, kOne = 1, kZero = 0;
    constexpr char kNone = 0;
    put(kMagic, kVersion);
    // The channel's name, type, linearity with 3 bytes of nothing, and sampling; then the end of the list.
    attribute("channels", "chlist", 'Z', kNone, kFloat, kZero, kOne, kOne, kNone);
    attribute("compression", "compression", kNone);
    for (const char* window : {"dataWindow", "displayWindow"})
        attribute(window, "box2i", kZero, kZero, width - 1, height - 1);
    attribute("lineOrder", "lineOrder", kNone);  // from the top
    attribute("pixelAspectRatio", "float", 1.0f);
    attribute("screenWindowCenter", "v2f", 0.0f, 0.0f);
    attribute("screenWindowWidth", "float", 1.0f);
    put(kNone);
    const std::uint64_t line = 2 * sizeof(std::int32_t) + row_bytes,
                        first = bytes.size() + sizeof(std::uint64_t) * static_cast<std::uint64_t>(height);
    bytes.reserve(first + line * static_cast<std::uint64_t>(height));
    for (int y = 0; y < height; ++y) put(first + line * static_cast<std::uint64_t>(y));
    for (int y = 0; y < height; ++y) {
        put(y, static_cast<std::int32_t>(row_bytes));
        bytes.append(reinterpret_cast<const char*>(values.data()) + row_bytes * static_cast<std::size_t>(y),
                     row_bytes);
    }
    return {bytes.begin(), bytes.end()};
}

void write_png(const std::filesystem::path& path, const Image& image) {
    FileTransaction files;
    files.write(path, encode_png(image));
    files.commit();
}

void write_pfm(const std::filesystem::path& path, int width, int height, const std::vector<float>& values) {
    FileTransaction files;
    files.write(path, encode_pfm(width, height, values));
    files.commit();
}

}  // namespace hexrelief::exporters
