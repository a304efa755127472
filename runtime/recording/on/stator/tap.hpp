// The taps of a build that records: each port writes what it takes and publishes into the stream of
// its activation.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stator/canonical.hpp"
#include "stator/crc32.hpp"
#include "stator/recording.hpp"

namespace stator {

inline constexpr bool kRecords = true;

// What `Tap::completes` does.
[[gnu::noinline]] inline void complete_sample(const RecordedOutput& output, void* message) {
    canonicalise(static_cast<std::byte*>(message), output.floats, output.float_count);
}

// What `Tap::publishes` does.
[[gnu::noinline]] inline void record_sample(RecordStream& stream, const RecordedOutput& output,
                                            const void* message, uint32_t bytes) {
    stream.number(output.tag);
    if (output.how == RecordedOutput::How::kStamp) return;
    if (output.how == RecordedOutput::How::kWhole) return stream.data(message, bytes);
    const uint32_t crc = crc32(0, message, bytes);
    stream.data(&crc, sizeof crc);
}

// A port's connection to the stream of its activation. Its functions hand on numbers and are
// inlined: so the optimiser can still take the ports of an activation apart.
class Tap {
  public:
    // `number`: of the newest sample that this port has recorded; for the tap to bring up to date.
    void connect(RecordStream& stream, uint8_t tag, uint32_t& number) {
        stream_ = &stream;
        tag_ = tag;
        number_ = &number;
    }
    void connect(RecordStream& stream, const RecordedOutput& output, uint32_t& number) {
        connect(stream, output.tag, number);
        output_ = &output;
    }

    // An input: a sample was taken, whether or not the node comes to see it.
    [[gnu::always_inline]] void takes(uint32_t number) {
        if (stream_ == nullptr) return;
        stream_->number(tag_);
        published(number);
    }
    // The same of an input that takes one sample before `step`; recorded behind it, so that it
    // does not wait.
    [[gnu::always_inline]] void notes(uint32_t number) {
        noted_ = number;
        has_noted_ = true;
    }
    [[gnu::always_inline]] void record_noted() {
        if (has_noted_) takes(noted_);
    }
    // An output: before anybody reads the sample. A replay's readers get it as it is then.
    [[gnu::always_inline]] void completes(void* message) {
        if (stream_ == nullptr || output_->float_count == 0) return;
        complete_sample(*output_, message);
    }
    // While nobody else touches it ...
    [[gnu::always_inline]] void publishes(const void* message, uint32_t bytes) {
        if (stream_ != nullptr) record_sample(*stream_, *output_, message, bytes);
    }
    // ... and then its number.
    [[gnu::always_inline]] void published(uint32_t number) {
        if (stream_ == nullptr) return;
        stream_->number(number - *number_);
        *number_ = number;
    }

  private:
    RecordStream* stream_ = nullptr;
    const RecordedOutput* output_ = nullptr;
    uint32_t* number_ = nullptr;
    uint32_t noted_ = 0;
    uint8_t tag_ = 0;
    bool has_noted_ = false;
};

// The taps of a port that publishes several topics, one for each.
class Taps {
  public:
    // `outputs` and `numbers`: by topic, as in `Tap::connect`.
    void connect(RecordStream& stream, const RecordedOutput* outputs, uint32_t* numbers) {
        stream_ = &stream;
        outputs_ = outputs;
        numbers_ = numbers;
    }
    Tap at(size_t topic) const {
        Tap tap;
        if (stream_ != nullptr) tap.connect(*stream_, outputs_[topic], numbers_[topic]);
        return tap;
    }

  private:
    RecordStream* stream_ = nullptr;
    const RecordedOutput* outputs_ = nullptr;
    uint32_t* numbers_ = nullptr;
};

}  // namespace stator
