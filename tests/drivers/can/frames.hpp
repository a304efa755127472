// Frames of DroneCAN messages, as others on the bus send them, and back.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <vector>

#include "messages/can_frame.hpp"
#include "stator/dronecan/codec.hpp"
#include "stator/dronecan/port.hpp"
#include "stator/dronecan/sender.hpp"

namespace stator {

inline constexpr uint8_t kOwnId = 10;

template <class Message>
std::vector<CanFrame> frames_of(const Message& message, uint8_t source, uint64_t time_us,
                                uint8_t transfer_id = 0) {
    dronecan::Sender<Message::kType.most_bytes> sender;
    sender.begin({.source = source, .destination = kOwnId, .discriminator = 5}, transfer_id,
                 message);
    std::vector<CanFrame> frames;
    for (dronecan::Frame frame; sender.next(frame);) {
        frames.push_back(dronecan::to_topic<CanFrame>(frame, time_us));
        frames.back().timestamp = time_us;
    }
    return frames;
}

template <class Message>
Message decoded(const CanFrame& single) {
    Message message;
    EXPECT_TRUE(dronecan::decode(std::span(single.data).first(single.length - 1U), message));
    return message;
}

}  // namespace stator
