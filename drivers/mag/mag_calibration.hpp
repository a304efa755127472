// What the drivers of this class take from each sample.
#pragma once

#include <array>

#include "messages/mag_calibration.hpp"

namespace stator::drivers::mag {

inline std::array<float, 3> calibrated(const MagCalibration& calibration,
                                       const std::array<float, 3>& raw) {
    const std::array<float, 3> v{raw[0] - calibration.offset[0], raw[1] - calibration.offset[1],
                                 raw[2] - calibration.offset[2]};
    const std::array<float, 9>& r = calibration.rotation;
    return {r[0] * v[0] + r[1] * v[1] + r[2] * v[2], r[3] * v[0] + r[4] * v[1] + r[5] * v[2],
            r[6] * v[0] + r[7] * v[1] + r[8] * v[2]};
}

}  // namespace stator::drivers::mag
