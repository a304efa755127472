// The recording of a flight in its log: messages of type 'X', as docs/recording.md has them.
// Readers of ULog pass over messages of a type that they do not know; but not among the
// definitions, where each is packed into an information message.
#include <algorithm>
#include <cstring>
#include <string_view>

#include "logger.hpp"
#include "stator/crc32.hpp"

namespace stator::apps::logger {

namespace {

constexpr char kRecording = 'X';
// Among the definitions: not the rest of another one; the key's length; the key, of a type that
// readers do not know, so that they pass over it.
constexpr std::string_view kPacked{"\0\x10stator recording", 18};
constexpr size_t kHead = 4 + kPacked.size();  // most bytes of such a message before its content
constexpr size_t kMinChunk = 32;  // less of a stream is not worth a message at the end of a block

}  // namespace

void Logger::write_recorded_definitions(LoggerPorts& ports, const RecordingTable& table) {
    for (; recorded_ < table.definition_count && tail_.empty() && has_room_to_define();
         ++recorded_) {
        tail_ = table.definitions[recorded_];
        begin_recorded(ports, Kind::kDefinition, 0, tail_.size());
        write_tail(ports);
    }
}

// What finds no room in this activation's blocks waits for the next one.
void Logger::write_streams(LoggerPorts& ports, const RecordingTable& table) {
    if (!tail_.empty()) return;
    for (unsigned level = 0; level < table.stream_count; ++level) {
        RecordStream& stream = *table.streams[level];
        write_stream(ports, stream, level);
        write_gap(ports, stream.lost(), level);
    }
}

void Logger::write_stream(LoggerPorts& ports, RecordStream& stream, unsigned level) {
    for (uint32_t left = stream.available(); left != 0 && has_room();) {
        if (used_ + kHead + std::min<size_t>(left, kMinChunk) > kBlockBytes) flush(ports);
        const size_t room = kBlockBytes - used_ - kHead;
        const auto bytes = stream.peek(static_cast<uint32_t>(std::min<size_t>(left, room)));
        begin_recorded(ports, Kind::kStream, level, bytes.size());
        write(ports, bytes.data(), bytes.size());
        stream.take(static_cast<uint32_t>(bytes.size()));
        left -= static_cast<uint32_t>(bytes.size());
    }
}

void Logger::write_gap(LoggerPorts& ports, uint32_t lost, unsigned level) {
    if (lost == gaps_[level] || !has_room()) return;
    gaps_[level] = lost;
    begin_recorded(ports, Kind::kGap, level, sizeof lost);
    write(ports, &lost, sizeof lost);
}

// Ends what one CRC covers: everything since the check before, this message's head included.
void Logger::write_check(LoggerPorts& ports) {
    begin_recorded(ports, Kind::kCheck, 0, sizeof crc_);
    check_block();
    write(ports, &crc_, sizeof crc_);
    crc_ = 0;
    checked_ = used_;
}

void Logger::begin_recorded(LoggerPorts& ports, Kind kind, unsigned level, size_t bytes) {
    if (has_subscribed(ports)) {
        begin(ports, kRecording, sizeof kind + bytes);
    } else {
        begin(ports, 'M', kPacked.size() + sizeof kind + bytes);
        write_text(ports, kPacked);
    }
    const auto head = static_cast<uint8_t>(static_cast<unsigned>(kind) | level);
    write(ports, &head, sizeof head);
}

void Logger::check_block() {
    crc_ = crc32(crc_, block_.data.data() + checked_, used_ - checked_);
    checked_ = used_;
}

}  // namespace stator::apps::logger
