// Between the frames of a graph's topics (message CanFrame) and those of transfers.
#pragma once

#include "stator/dronecan/frame.hpp"

namespace stator::dronecan {

// False for what cannot belong to a transfer.
template <class CanFrame>
[[nodiscard]] bool from_topic(const CanFrame& received, Frame& frame) {
    frame = {.id = received.id, .length = received.length, .data = received.data};
    return received.extended;
}

template <class CanFrame>
[[nodiscard]] CanFrame to_topic(const Frame& frame, uint64_t timestamp_sample) {
    return CanFrame{.timestamp_sample = timestamp_sample,
                    .id = frame.id,
                    .extended = true,
                    .length = frame.length,
                    .data = frame.data};
}

}  // namespace stator::dronecan
