// The calibrations that are known: their names, and what each key in them means.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "pipeline/readers/cameras/entries.h"

namespace hexrelief::readers::codec {

// What a key holds. Those before `rotation` are of one camera, the others of the pair.
enum class Part {
    matrix,   // K, 3x3 or the upper left of 3x4 or 4x4
    lengths,  // fx fy cx cy
    focal,    // one length or two, px
    centre,   // cx cy
    fx,
    fy,
    cx,
    cy,          // px
    fov_x,       // degrees
    angle_x,     // radians
    distortion,  // in OpenCV's order
    radial,      // k1 k2, or k1 k2 k3
    tangential,  // p1 p2
    k1,
    k2,
    k3,
    k4,
    k5,
    k6,
    p1,
    p2,
    width,
    height,
    size,            // width height
    model,           // name of the lens's model
    rectification,   // rotation from the camera to the rectified camera
    projection,      // of the rectified camera, 3x4
    pose,            // from the camera to the body, 4x4
    body_to_camera,  // from the body to the camera, 4x4
    rotation,        // from left to right: 3x3, or a rotation vector
    transposed,      // its transpose
    rotation_x,
    rotation_y,
    rotation_z,   // of its vector
    translation,  // from left to right
    translation_x,
    translation_y,
    translation_z,
    transform,       // from left to right, 4x4
    transform_back,  // from right to left, 4x4
    baseline,
    baseline_px,   // baseline times focal length
    q,             // cv::stereoRectify's Q
    depth_scale,   // of integers of depth, in a unit that its size tells
    depth_factor,  // integers of depth in a metre
};

struct Meaning {
    Part part;
    Side side;
    int rank;  // the least of several names of one part goes before the others
};
// Returns what the entry's key means, and its side if the key says it; nullopt for a key that is not known,
// or a number of values that it cannot have.
std::optional<Meaning> meaning_of(const Entry& entry);

// True for a list under the key of a matrix that is not of a matrix's length.
bool lacks_numbers(const Entry& entry);

// A kind of calibration files.
struct Family {
    const char* name;   // for messages: "ROS camera_info"
    const char* holds;  // for lists: the keys by which it is recognised
    const char* gives;  // for lists: "a pair to rectify", "a rectified pair", "one view"
    // Keys in plain_name(), separated by spaces, of which one is in each file of the family: "a+b" means
    // both, "PAIR" a matrix of one of two cameras, "RECTIFIED" the projections of both. Empty: a format of
    // its own, not made of entries.
    const char* marks;
    double centre = 0;           // the coordinate that it gives the first pixel's centre
    double unit_m = 1;           // of its lengths
    const char* told = nullptr;  // an assumption to be told
    // Names the entries of a file with cameras of several sizes, or of several sockets, as those of one pair.
    Entries (*select)(const CalibrationText& source, Entries entries) = nullptr;
    bool is_height_first = false;  // in sizes
};

// Return the cameras of a file as entries of one pair: those of the pictures' size, or of any if it is not
// known, and of DepthAI's left and right socket; and of a list of views, BOP's by their numbers or
// nerfstudio's by their files, that of the picture or map, or all if it is not in the list.
Entries select_zed(const CalibrationText& source, Entries entries);
Entries select_d400(const CalibrationText& source, Entries entries);
Entries select_oak(const CalibrationText& source, Entries entries);
Entries select_view(const CalibrationText& source, Entries entries);

// Returns all families in the order in which they are tried.
std::span<const Family> families();

// Returns the first family whose keys the file has; null if there is none.
const Family* family_of(const Entries& entries);

// Returns the names of all families in one line.
std::string family_names();

}  // namespace hexrelief::readers::codec
