// Where right inputs end and wrong ones begin. Each lies between what right and wrong ones show, and not
// close to any one scene's figure: EXPERIMENTS.md has both.
#pragma once

namespace hexrelief::checks {

// Pairs.
constexpr double kLeastTexture = 0.1;     // of the reduced picture's blocks
constexpr double kLeastAtZero = 0.98;     // of the reduced picture's known pixels; below, views are not equal
constexpr double kMostDifference = 0.9;   // of the difference to the next column; likewise, above
constexpr double kSureAgreement = 0.8;    // of the reduced picture; below, the pair is looked at more closely
constexpr double kLeastAgreement = 0.45;  // likewise; below, and where points do not agree either, it is none
constexpr int kLeastPoints = 20;          // that agree on the rows
constexpr double kLeastAgreeingPoints = 0.7;
constexpr double kLargestRow_px = 1;
constexpr double kLargestCoarseRow = 0.25;  // of the reduced pair's px, beside the above
constexpr double kSwappedBelow = 0.85;      // of the points, below 0
constexpr double kSwappedAgreement = 0.5;   // of the reduced picture, the other way round
constexpr double kMostBelow = 0.05;         // of the points, below the range searched
constexpr double kMostAtLowEnd = 0.05;      // of the known pixels; above, the pair is looked at more closely
constexpr double kMostBeyond = 0.003;       // of the reduced picture's known pixels
constexpr double kWidestRange = 3;          // times what the scene needs
constexpr int kFreeRange_px = 32;           // a range may always be as much wider

// Maps.
constexpr int kLeastValues = 200;
constexpr int kLeastTurns = 80;
constexpr double kMostTopmost = 0.1;          // of the places where values turn
constexpr double kLeastRoundness = 0.41;      // of those
constexpr double kDepthLike = -0.25;          // correlation with the row and straightness
constexpr double kLargestStraightness = 0.5;  // planes must not outweigh the correlation
constexpr double kLargest = 0.6;              // of the width
constexpr double kLargestOfBytes = 0.17;      // likewise, of whole numbers up to 255
constexpr double kLeastOfLargest = 0.005;     // likewise
constexpr int kLeastSteps = 200;
constexpr double kLeastContrast = 1.43;  // at the map's steps, of that around them
constexpr double kLeastDeviations = 9;   // of it from that around
constexpr double kLeastHere = 0.85;      // of the contrast where it is largest
constexpr int kLeastShift_px = 3;

// Cameras.
constexpr double kLargestBaseline_m = 5;  // on vehicles 1.5 m; of phones in mm 12
constexpr double kLeastDepth_m = 0.05, kLargestDepth_m = 1000;

}  // namespace hexrelief::checks
