// Reads the recording out of a flight log: docs/recording.md has the format.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stator::replay {

enum class Kind { kApp, kDriver, kLogger, kParameters };

struct Port {
    size_t topic;
    bool is_input;
    bool is_cursor;  // a trigger or queue: has a start when its node is constructed anew
    bool is_whole;   // an output whose samples are recorded, not their hash
    bool is_stamp;   // an output of which only the times are recorded
};

struct TaskRow {
    std::string name;
    unsigned level = 0;
    Kind kind = Kind::kApp;
    std::vector<Port> ports;  // tag 1 is the first
};

struct TopicRow {
    std::string name;
    size_t bytes = 0;
};

inline constexpr size_t kStreams = 16;

struct Recording {
    std::vector<TopicRow> topics;
    std::vector<TaskRow> tasks;
    bool has_modes = false;
    std::array<std::vector<uint8_t>, kStreams> streams;  // by level
    std::array<bool, kStreams> has_gap{};                // its stream ends before the others
};

// Reads the first `count` bytes of the log, which the command line has checked. Nothing if the file
// cannot be read or makes no sense.
std::optional<Recording> read_recording(const char* log, size_t count);

// Goes through the bytes of a stream. Past the end it reads zeros and says so.
class Reader {
  public:
    Reader(const std::vector<uint8_t>& bytes, size_t at) : bytes_(&bytes), at_(at) {}
    uint64_t number();
    uint32_t word();
    const uint8_t* skip(size_t count);  // to what it skips; null past the end
    size_t at() const { return at_; }
    bool is_past_end() const { return is_past_end_; }

  private:
    const std::vector<uint8_t>* bytes_;
    size_t at_;
    bool is_past_end_ = false;
};

}  // namespace stator::replay
