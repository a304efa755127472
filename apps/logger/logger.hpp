// The flight log as ULog v1 (docs.px4.io, "ULog File Format"): definitions first, then samples, and
// between these the recording, in messages of its own (docs/recording.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "logger_ports.hpp"

namespace stator::apps::logger {

// Collects log messages into blocks and publishes each block when it is full; what is left is
// published when time has come to flush it. The table says how many blocks an activation publishes
// at most: somewhat more than the log takes. What is left of the definitions or samples waits for
// the next one. A recording never waits for definitions, as its rings are small.
class Logger {
  public:
    void step(LoggerPorts& ports);

  private:
    static constexpr size_t kBlockBytes = sizeof(LogBlock::data);
    static constexpr uint64_t kFlushInterval_us = 100'000;

    bool has_room() const { return published_ < blocks_at_once_; }
    // Definitions leave the last block to samples, so that these wait for no later activation.
    bool has_room_to_define() const { return published_ + 1 < blocks_at_once_; }
    bool write_definitions(LoggerPorts& ports);
    bool has_subscribed(const LoggerPorts& ports) const;
    void write_definition(LoggerPorts& ports, uint32_t index);
    void write_header(LoggerPorts& ports);
    void write_subscription(LoggerPorts& ports, uint16_t id);
    void write_format(LoggerPorts& ports, const LogTopic& row);
    void write_parameter(LoggerPorts& ports, const LogParameter& parameter);
    void write_replaced(LoggerPorts& ports, uint32_t index);
    void write_value(LoggerPorts& ports, const LogParameter& parameter);
    void write_changes(LoggerPorts& ports, const LogChanges& changes);
    bool write_changes_of(LoggerPorts& ports, const LogChanges& changes, uint32_t topic,
                          const void* sample);
    void write_info(LoggerPorts& ports, std::string_view key, std::string_view text);
    void write_events(LoggerPorts& ports);
    void write_samples(LoggerPorts& ports);
    void write_sample(LoggerPorts& ports, const LogTopic& row, uint16_t id,
                      const std::byte* sample);
    void write_dropout(LoggerPorts& ports, uint64_t duration_us);

    // recording.cpp
    enum class Kind : uint8_t { kStream = 0x00, kDefinition = 0x10, kGap = 0x20, kCheck = 0x30 };
    void write_streams(LoggerPorts& ports, const RecordingTable& table);
    void write_recorded_definitions(LoggerPorts& ports, const RecordingTable& table);
    void write_stream(LoggerPorts& ports, RecordStream& stream, unsigned level);
    void write_gap(LoggerPorts& ports, uint32_t lost, unsigned level);
    void write_check(LoggerPorts& ports);
    void begin_recorded(LoggerPorts& ports, Kind kind, unsigned level, size_t bytes);
    void check_block();

    void begin(LoggerPorts& ports, char type, size_t bytes);
    void write(LoggerPorts& ports, const void* bytes, size_t count);
    void write_text(LoggerPorts& ports, std::string_view text);
    void write_tail(LoggerPorts& ports);
    void flush(LoggerPorts& ports);

    uint32_t defined_ = 0;   // definitions written
    std::string_view tail_;  // of the newest definition, which may be longer than a block
    uint32_t events_read_ = 0;
    unsigned published_ = 0;  // blocks of this activation
    unsigned blocks_at_once_ = 0;
    size_t used_ = 0;
    uint64_t flushed_us_ = 0;
    uint32_t lost_ = 0;
    uint64_t previous_us_ = 0;
    // Of the recording: definitions written; activations known to be lost, by level; CRC-32 of the
    // log since the last check, up to byte `checked_` of the block.
    uint32_t recorded_ = 0;
    std::array<uint32_t, kMaxStreams> gaps_{};
    uint32_t crc_ = 0;
    size_t checked_ = 0;
    LogBlock block_{};
};

}  // namespace stator::apps::logger
