// Pairs of a made-up scene by cameras that are turned by known angles.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::alignment {

// Angles in degrees: of the right camera less those of the left one, and the means of both.
struct TurnedCameras {
    double pitch = 0, yaw = 0, roll = 0, common_yaw = 0, common_roll = 0;
    double focal_px = 576, right_focal = 1;  // of the left camera; times that of the right one
    double radial = 0;                       // straight = bent * (1 + radial * r^2), r = 1 at a corner
    double baseline = 0.15, forward = 0;     // of the right camera against the left one
    int width = 640, height = 480;
    unsigned seed = 1;  // of the textures
};

// Renders boards at depths from 2 to 6 before a wall and a floor, all with textures of several sizes.
StereoPair render_pair(const TurnedCameras& cameras);

}  // namespace hexrelief::alignment
