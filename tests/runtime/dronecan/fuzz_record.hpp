// What an input of the fuzzer is made of: a list of frames, in records of 16 bytes.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include "stator/dronecan/frame.hpp"

namespace stator::dronecan::fuzz {

constexpr unsigned kRecord = 16;
constexpr std::uint8_t kOwnId = 10;

// Identifier (4 bytes), time since the one before in ms (1), length (1; 4 bits count), data (8),
// two unused.
struct Record {
    Frame frame;
    std::uint8_t pause_ms = 0;
};

inline Record record_of(const std::uint8_t* bytes) {
    Record record{.pause_ms = bytes[4]};
    std::memcpy(&record.frame.id, bytes, sizeof record.frame.id);
    record.frame.length = bytes[5] & 0xF;
    std::memcpy(record.frame.data.data(), bytes + 6, kMaxFrameBytes);
    return record;
}

inline void write_record(const Record& record, std::uint8_t* bytes) {
    std::memset(bytes, 0, kRecord);
    std::memcpy(bytes, &record.frame.id, sizeof record.frame.id);
    bytes[4] = record.pause_ms;
    bytes[5] = record.frame.length;
    std::memcpy(bytes + 6, record.frame.data.data(), kMaxFrameBytes);
}

}  // namespace stator::dronecan::fuzz
