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

// Of a message with a NaN that the processor has made, which is rare.
template <class Message>
[[gnu::cold, gnu::noinline]] void make_canonical(Message* message) {
    for (const auto& [offset, count, bytes] : Message::kFloatRuns) {
        const FloatRun run{offset, count, static_cast<uint8_t>(bytes)};
        canonicalise(reinterpret_cast<std::byte*>(message), &run, 1);
    }
}

// A sample that was published, with its hash, and its number less that of the one before.
[[gnu::always_inline]] inline void record_hash(RecordStream& stream, uint8_t tag, uint32_t hash,
                                               uint32_t further) {
    if (!stream.has_room(RecordStream::kTakeBytes + sizeof hash)) return;
    RecordStream::Part part(stream);
    part.byte(tag);
    part.word(hash);
    part.number(further);
}
// The sample itself; its number follows.
[[gnu::always_inline]] inline void record_bytes(RecordStream& stream, uint8_t tag,
                                                const void* sample, uint32_t bytes) {
    RecordStream::Part(stream).byte(tag);
    stream.append(sample, bytes);
}
[[gnu::always_inline]] inline void record_whole(RecordStream& stream, uint8_t tag,
                                                const void* sample, uint32_t bytes,
                                                uint32_t further) {
    if (!stream.has_room(RecordStream::kTakeBytes + bytes)) return;
    record_bytes(stream, tag, sample, bytes);
    RecordStream::Part(stream).number(further);
}

// Of a sample that stays as it is until it is recorded.
[[gnu::noinline]] inline void record_publication(RecordStream& stream, const RecordedOutput& output,
                                                 const void* sample, uint32_t bytes,
                                                 uint32_t further) {
    switch (output.how) {
        case RecordedOutput::How::kHash:
            return record_hash(stream, output.tag, sample_hash(sample, bytes), further);
        case RecordedOutput::How::kWhole:
            return record_whole(stream, output.tag, sample, bytes, further);
        case RecordedOutput::How::kStamp:
            return stream.take(output.tag, further);
    }
}

// Of one whose slot may be reused once it is committed: before that, what depends on the sample.
// Returns its hash.
[[gnu::noinline]] inline uint32_t record_sample(RecordStream& stream, const RecordedOutput& output,
                                                const void* sample, uint32_t bytes) {
    if (output.how == RecordedOutput::How::kHash) return sample_hash(sample, bytes);
    if (output.how == RecordedOutput::How::kWhole &&
        stream.has_room(RecordStream::kTakeBytes + bytes)) {
        record_bytes(stream, output.tag, sample, bytes);
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
    template <class Message>
    [[gnu::always_inline]] void builds(Message* message) {
        if constexpr (requires { Message::kFloatRuns; }) {
            if (has_other_nan(*message)) [[unlikely]] {
                make_canonical(message);
            }
        }
    }
    void builds(std::byte* sample) {
        if (stream_ != nullptr) canonicalise(sample, output_->floats, output_->float_count);
    }
    // ... and behind its commit, if it stays as it is until then ...
    [[gnu::always_inline]] void published(const void* sample, uint32_t bytes, uint32_t number) {
        if (stream_ == nullptr) return;
        asm volatile("" ::: "memory");  // what follows waits until the subscribers are pended
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
