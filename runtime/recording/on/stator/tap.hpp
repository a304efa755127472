// The taps of a build that records: each port writes what it takes and publishes into the stream of
// its activation.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stator/canonical.hpp"
#include "stator/recording.hpp"
#include "stator/sample_hash.hpp"

namespace stator {

inline constexpr bool kRecords = true;

[[gnu::noinline]] inline void make_canonical(const RecordedOutput& output, void* sample) {
    canonicalise(static_cast<std::byte*>(sample), output.floats, output.float_count);
}

// A sample that was published, with its hash, and its number less that of the one before.
[[gnu::always_inline]] inline void record_hash(RecordStream& stream, uint8_t tag, uint32_t hash,
                                               uint32_t further) {
    if (!stream.has_room(RecordStream::kTakeBytes + sizeof hash)) return;
    RecordStream::Part part(stream);
    part.byte(tag);
    for (unsigned i = 0; i < sizeof hash; ++i) part.byte(static_cast<uint8_t>(hash >> (8 * i)));
    part.number(further);
}
// The sample itself; its number follows.
[[gnu::always_inline]] inline void record_whole(RecordStream& stream, uint8_t tag,
                                                const void* sample, uint32_t bytes) {
    if (!stream.has_room(RecordStream::kTakeBytes + bytes)) return;
    RecordStream::Part part(stream);
    part.byte(tag);
    part.bytes(sample, bytes);
}

// Of a sample that stays as it is until it is recorded.
[[gnu::noinline]] inline void record_publication(RecordStream& stream, const RecordedOutput& output,
                                                 const void* sample, uint32_t bytes,
                                                 uint32_t further) {
    switch (output.how) {
        case RecordedOutput::How::kHash:
            return record_hash(stream, output.tag, sample_hash(sample, bytes), further);
        case RecordedOutput::How::kWhole:
            record_whole(stream, output.tag, sample, bytes);
            return stream.number(further);
        case RecordedOutput::How::kStamp:
            return stream.take(output.tag, further);
    }
}

// Of one whose slot may be reused once it is committed: before that, what depends on the sample.
// Returns its hash.
[[gnu::noinline]] inline uint32_t record_sample(RecordStream& stream, const RecordedOutput& output,
                                                const void* sample, uint32_t bytes) {
    if (output.how == RecordedOutput::How::kHash) return sample_hash(sample, bytes);
    if (output.how == RecordedOutput::How::kWhole) {
        record_whole(stream, output.tag, sample, bytes);
    }
    return 0;
}
[[gnu::noinline]] inline void record_commit(RecordStream& stream, const RecordedOutput& output,
                                            uint32_t hash, uint32_t further) {
    switch (output.how) {
        case RecordedOutput::How::kHash:
            return record_hash(stream, output.tag, hash, further);
        case RecordedOutput::How::kWhole:
            return stream.number(further);
        case RecordedOutput::How::kStamp:
            return stream.take(output.tag, further);
    }
}

// A port's connection to the stream of its activation. Its functions hand on numbers and are
// inlined: so the optimiser can still take the ports of an activation apart.
class Tap {
  public:
    // `number`: of the newest sample that this port has recorded; for the tap to bring up to date.
    [[gnu::always_inline]] void connect(RecordStream& stream, uint8_t tag, uint32_t& number) {
        stream_ = &stream;
        tag_ = tag;
        number_ = &number;
    }
    [[gnu::always_inline]] void connect(RecordStream& stream, const RecordedOutput& output,
                                        uint32_t& number) {
        connect(stream, output.tag, number);
        output_ = &output;
    }

    // An input: a sample was taken, whether or not the node comes to see it.
    [[gnu::always_inline]] void takes(uint32_t number) {
        if (stream_ == nullptr) return;
        stream_->take(tag_, further(number));
    }
    // The same of an input that takes one sample before `step`; recorded behind it, so that it
    // does not wait.
    [[gnu::always_inline]] void notes(uint32_t number) {
        noted_ = number;
        has_noted_ = true;
    }
    [[gnu::always_inline]] void record_noted(RecordStream::Part& part) {
        if (has_noted_) part.take(tag_, further(noted_));
    }
    // An output: before anyone can read the sample ...
    [[gnu::always_inline]] void builds(void* sample) {
        if (stream_ != nullptr && output_->float_count != 0) make_canonical(*output_, sample);
    }
    // ... and behind its commit, if it stays as it is until then ...
    [[gnu::always_inline]] void published(const void* sample, uint32_t bytes, uint32_t number) {
        if (stream_ == nullptr) return;
        record_publication(*stream_, *output_, sample, bytes, further(number));
    }
    // ... or what its slot's next user could change before the commit, and the rest behind it.
    [[gnu::always_inline]] uint32_t commits(const void* sample, uint32_t bytes) {
        return stream_ == nullptr ? 0 : record_sample(*stream_, *output_, sample, bytes);
    }
    [[gnu::always_inline]] void committed(uint32_t hash, uint32_t number) {
        if (stream_ == nullptr) return;
        record_commit(*stream_, *output_, hash, further(number));
    }

  private:
    [[gnu::always_inline]] uint32_t further(uint32_t number) {
        const uint32_t before = *number_;
        *number_ = number;
        return number - before;
    }

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
