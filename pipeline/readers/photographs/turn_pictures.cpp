#include "pipeline/readers/photographs/turn_pictures.h"

#include <cmath>
#include <utility>

namespace hexrelief::readers {
namespace {

// Returns how far the aspects of a picture and of a map are from each other, as a logarithm.
double aspect_difference(const Image& image, int width, int height) {
    return std::fabs(std::log(1.0 * image.width * height / (1.0 * image.height * width)));
}

// Returns what was done.
std::string turn(OrientedPicture& picture) {
    picture.image = upright(std::move(picture.image), picture.orientation);
    return picture.path.string() + " is " + orientation_text(picture.orientation) +
           ", as its EXIF orientation says";
}

}  // namespace

Turning turn_upright(OrientedPicture& left, OrientedPicture& right, bool has_calibration) {
    Turning done;
    const bool is_stored_equal =
        left.image.width == right.image.width && left.image.height == right.image.height;
    if (is_stored_equal && is_quarter_turn(left.orientation) != is_quarter_turn(right.orientation)) {
        done.warnings.push_back("the EXIF orientations of " + left.path.string() + " and " +
                                right.path.string() +
                                " would give them different sizes: both are taken as stored");
        return done;
    }
    for (OrientedPicture* const picture : {&left, &right}) {
        if (picture->orientation == kUpright) continue;
        const std::string told = turn(*picture);
        if (has_calibration)
            done.warnings.push_back(
                told +
                "; if the calibration is for the picture as stored, set input.exif_orientation to "
                "false");
        else
            done.decisions.push_back("orientation: " + told);
    }
    return done;
}

Turning turn_to_fit(OrientedPicture& color, int width, int height) {
    Turning done;
    if (color.orientation == kUpright) return done;
    const bool is_quarter = is_quarter_turn(color.orientation);
    const double stored = aspect_difference(color.image, width, height);
    const double turned = is_quarter ? aspect_difference(color.image, height, width) : stored;
    if (turned < stored)
        done.decisions.push_back("orientation: " + turn(color) + ", to fit the map");
    else if (turned > stored)
        done.decisions.push_back("orientation: " + color.path.string() +
                                 " is taken as stored, as the map is");
    else
        done.warnings.push_back(
            "the map fits " + color.path.string() + " as stored and " + orientation_text(color.orientation) +
            ", as its EXIF orientation says: it is taken as stored; if the map is of the picture as "
            "it is seen, save the picture again without that orientation");
    return done;
}

}  // namespace hexrelief::readers
