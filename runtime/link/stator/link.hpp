// The vehicle's side of the link: bytes in, bytes out, an answer to each request. docs/link.md.
#pragma once

#include "stator/frame.hpp"

namespace stator {

// How bytes travel; neither function waits.
struct Transport {
    size_t (*read)(uint8_t* bytes, size_t most);          // how many came
    size_t (*write)(const uint8_t* bytes, size_t count);  // how many went
};

// What execution times are counted in.
struct TickSource {
    uint32_t hz;
    uint8_t unit;      // 0: cycles of the core; 1: instructions of an emulator; 2: ns of CPU time
    uint8_t per_unit;  // ticks in one of these
};

// Serves one request after the other. `answer` gets a request and writes the answer's body, of at
// most `kMaxAnswer` bytes; 0: there is none. Context: one, less urgent than all tasks.
class Link {
  public:
    static constexpr size_t kMaxRequest = 16;
    static constexpr size_t kMaxAnswer = 1040;
    using Answer = size_t (*)(const uint8_t* request, size_t count, uint8_t* body);

    explicit constexpr Link(Answer answer) : answer_(answer) {}

    // `Bytes`: a `Transport`, or what has the same two functions.
    template <class Bytes>
    void serve(Bytes& transport) {
        send(transport);
        uint8_t byte = 0;
        while (sent_ == size_ && transport.read(&byte, 1) == 1) {
            if (!reader_.take(byte)) continue;
            const size_t count = answer_(reader_.body(), reader_.count(), body_.data());
            if (count == 0) continue;
            size_ = write_frame(body_.data(), count, frame_.data());
            sent_ = 0;
            send(transport);
        }
    }

    bool is_sending() const { return sent_ != size_; }

  private:
    template <class Bytes>
    void send(Bytes& transport) {
        if (sent_ != size_) sent_ += transport.write(frame_.data() + sent_, size_ - sent_);
    }

    Answer answer_;
    FrameReader<kMaxRequest> reader_{};
    std::array<uint8_t, kMaxAnswer + kCrcBytes> body_{};
    std::array<uint8_t, frame_bytes(kMaxAnswer)> frame_{};
    size_t size_ = 0;  // of the frame, and how much of it is sent
    size_t sent_ = 0;
};

}  // namespace stator
