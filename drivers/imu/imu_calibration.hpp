// What the drivers of this class take from each sample.
#pragma once

#include <array>

#include "messages/imu_calibration.hpp"

namespace stator::drivers::imu {

using Xyz = std::array<float, 3>;

inline Xyz turned(const std::array<float, 9>& rotation, const Xyz& v) {
    return {rotation[0] * v[0] + rotation[1] * v[1] + rotation[2] * v[2],
            rotation[3] * v[0] + rotation[4] * v[1] + rotation[5] * v[2],
            rotation[6] * v[0] + rotation[7] * v[1] + rotation[8] * v[2]};
}

inline Xyz calibrated_gyro(const ImuCalibration& calibration, const Xyz& raw) {
    const Xyz& offset = calibration.gyro_offset;
    return turned(calibration.rotation,
                  {raw[0] - offset[0], raw[1] - offset[1], raw[2] - offset[2]});
}

inline Xyz calibrated_accel(const ImuCalibration& calibration, const Xyz& raw) {
    const Xyz& offset = calibration.accel_offset;
    const Xyz& scale = calibration.accel_scale;
    return turned(calibration.rotation,
                  {scale[0] * (raw[0] - offset[0]), scale[1] * (raw[1] - offset[1]),
                   scale[2] * (raw[2] - offset[2])});
}

}  // namespace stator::drivers::imu
