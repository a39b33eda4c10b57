#include "pipeline/readers/cameras/exif_focal.h"

#include <libexif/exif-data.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string_view>
#include <vector>

#include "pipeline/readers/photographs/exif.h"

namespace hexrelief::readers {
namespace {

struct Release {
    void operator()(ExifData* data) const { exif_data_unref(data); }
};
using Exif = std::unique_ptr<ExifData, Release>;

// Returns a positive number under `tag`; 0 if there is none. `ifd` is the directory in which the
// standard has the tag.
double number_of(const Exif& exif, ExifIfd ifd, ExifTag tag) {
    const ExifEntry* entry = exif_content_get_entry(exif->ifd[ifd], tag);
    if (!entry || !entry->data || entry->components < 1 || entry->size < exif_format_get_size(entry->format))
        return 0;
    const ExifByteOrder order = exif_data_get_byte_order(exif.get());
    double value = 0;
    if (entry->format == EXIF_FORMAT_SHORT) {
        value = exif_get_short(entry->data, order);
    } else if (entry->format == EXIF_FORMAT_LONG) {
        value = exif_get_long(entry->data, order);
    } else if (entry->format == EXIF_FORMAT_RATIONAL) {
        const ExifRational ratio = exif_get_rational(entry->data, order);
        value = ratio.denominator > 0 ? 1.0 * ratio.numerator / ratio.denominator : 0;
    }
    return value;
}

std::string text(const char* format, double first, double second = 0) {
    char buffer[80];
    std::snprintf(buffer, sizeof buffer, format, first, second);
    return buffer;
}

double sensor_width_mm(const Exif& exif, double picture_px) {
    const double resolution = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_X_RESOLUTION);
    const double unit = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT);
    const double unit_mm = unit == 3 ? 10 : unit == 4 ? 1 : unit == 5 ? 0.001 : 25.4;
    const double taken_px = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_PIXEL_X_DIMENSION);
    if (!(resolution > 0)) return 0;
    return (taken_px > 0 ? taken_px : picture_px) / resolution * unit_mm;
}

}  // namespace

std::optional<ExifFocal> read_exif_focal(const std::filesystem::path& path, int width, int height) {
    std::vector<std::uint8_t> data = read_exif(path);
    if (data.empty()) return std::nullopt;
    constexpr std::string_view prefix("Exif\0\0", 6);  // by which libexif recognises them
    data.insert(data.begin(), prefix.begin(), prefix.end());
    const Exif exif(exif_data_new_from_data(data.data(), static_cast<unsigned>(data.size())));
    if (!exif) return std::nullopt;

    // A picture that was turned by a quarter has the sensor's width as its height.
    const double taken_x = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_PIXEL_X_DIMENSION);
    const double taken_y = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_PIXEL_Y_DIMENSION);
    const bool is_turned = taken_x > 0 && taken_y > 0 && (taken_x > taken_y) != (width > height);
    const int side = is_turned ? height : width;
    ExifFocal focal;
    const double film_mm = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM);
    const double lens_mm = number_of(exif, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH);
    if (film_mm > 0) {
        focal = {film_mm * std::hypot(width, height) / std::hypot(36, 24),
                 text("%g mm on 35 mm film", film_mm)};
    } else if (const double sensor_mm = sensor_width_mm(exif, side); lens_mm > 0 && sensor_mm > 0) {
        focal = {lens_mm / sensor_mm * side, text("%g mm on a sensor of %.3g mm", lens_mm, sensor_mm)};
    }
    // Numbers that give an angle of view above 170 or below 0.1 degrees are not those of a lens.
    const double longest = std::max(width, height);
    if (!(focal.focal_px > 0.04 * longest) || !(focal.focal_px < 600 * longest)) return std::nullopt;
    return focal;
}

}  // namespace hexrelief::readers
