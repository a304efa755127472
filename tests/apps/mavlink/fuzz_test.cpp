// Any bytes on both lines, through gates, parsers and handlers to the replies: no activation
// publishes more than its bursts (the harness expects it), replies are whole frames, and the
// heartbeat goes on.
#include <random>

#include "harness.hpp"
#include "stator/mavlink/gate.hpp"

#ifndef STATOR_FUZZ_BYTES
#define STATOR_FUZZ_BYTES 10'000'000
#endif

namespace stator::apps::mavlink {
namespace {

class FuzzTest : public MavlinkTest {
  protected:
    using Bytes = std::vector<uint8_t>;

    FuzzTest() {
        is_open_ = {true, true};
        params_.allows1 = params_.allows2 = 0x3FF;
        for (unsigned i = 0; i < 50; ++i) {
            parameters_.push_back({"P" + std::to_string(100 + i), ParameterValue::Type::kFloat,
                                   static_cast<float>(i), 0});
        }
        logs_.emplace_back(5'000, uint8_t{7});
    }

    unsigned below(unsigned count) { return static_cast<unsigned>(random_() % count); }
    bool happens(unsigned percent) { return below(100) < percent; }
    uint8_t byte() { return static_cast<uint8_t>(below(256)); }

    // A message that we know, with any payload, mostly for us.
    Bytes frame() {
        const mav::Known& known = mav::kKnown[below(static_cast<unsigned>(mav::kKnown.size()))];
        std::array<uint8_t, mav::kMaxPayload> payload{};
        const std::size_t length = happens(50) ? payload.size() : 1 + below(payload.size());
        const bool is_small = happens(50);  // numbers that are possible
        for (uint8_t& b : payload) b = is_small ? static_cast<uint8_t>(below(3)) : byte();
        if (known.target != mav::Known::kNoTarget && happens(80)) {
            const std::size_t at = known.target & ~unsigned{mav::Known::kHasComponent};
            payload[at] = 1;
            if (at + 1 < payload.size()) payload[at + 1] = 1;
        }
        const mav::Address from = happens(80) ? kGround : mav::Address{byte(), byte()};
        const mav::Signed as{.link = byte(), .time = now_us_ / 10 + below(1000)};
        const bool is_signed = happens(30);
        mav::FrameBytes bytes;
        bytes.put({.id = known.id, .crc_extra = known.crc_extra, .length = 255},
                  std::span(payload).first(length), byte(), from, is_signed ? &as : nullptr);
        return {bytes.bytes().begin(), bytes.bytes().end()};
    }
    Bytes some() {
        Bytes bytes;
        if (happens(15)) {
            for (unsigned i = below(80); i > 0; --i) bytes.push_back(happens(20) ? 0xFD : byte());
            return bytes;
        }
        bytes = frame();
        if (happens(10)) bytes[below(static_cast<unsigned>(bytes.size()))] ^= byte();
        if (happens(5)) bytes.resize(below(static_cast<unsigned>(bytes.size())));
        return bytes;
    }
    // What a line passes on, with some signatures made right before.
    void feed(unsigned line) {
        Bytes bytes = some();
        if (happens(80)) gates_[line].sign(bytes, true);
        fed_ += bytes.size();
        std::size_t at = 0;
        std::array<uint8_t, 64> piece{};
        std::size_t count = 0;
        do {
            count = gates_[line].pass(piece, now_us_, [&](uint8_t& b) {
                if (at == bytes.size()) return false;
                b = bytes[at++];
                return true;
            });
            send_bytes(std::span(piece).first(count), line);
        } while (count == piece.size());
    }
    // Keys come and go, as the drivers would do it.
    void adopt() {
        for (unsigned line = 0; line < 2; ++line) {
            for (const SerialBytes& order : adopted_[line]) {
                gates_[line].adopt(std::span(order.data).first(order.length));
            }
            adopted_[line].clear();
            gates_[line].follow(now_us_);
        }
        line_.signs = gates_[0].signs();
    }
    void forget_all() {
        for (unsigned line = 0; line < 2; ++line) {
            const auto& heard = stations_[line].heard;
            beats_heard_[line] += std::ranges::count(heard, mav::Heartbeat::kId, &Heard::id);
        }
        forget();
        commands_.clear();
        calibrations_.clear();
        setpoints_.clear();
        station_sticks_.clear();
        beats_.clear();
        kept_.clear();
    }

    mav::SharedKey key_;
    std::array<mav::Gate, 2> gates_{mav::Gate(key_, mav::kKnown), mav::Gate(key_, mav::kKnown)};
    std::array<std::ptrdiff_t, 2> beats_heard_{};
    std::size_t fed_ = 0;
    std::mt19937 random_{1};
};

TEST_F(FuzzTest, any_bytes_do_no_harm) {
    const uint64_t begin_us = now_us_;
    bool was_signed = false;
    bool was_unsigned = false;
    while (fed_ < STATOR_FUZZ_BYTES && !HasFailure()) {
        for (unsigned line = 0; line < 2; ++line) {
            for (unsigned i = 0; i < 8 && stations_[line].out.size() < 128; ++i) feed(line);
        }
        for (unsigned i = 0; i < 3; ++i) step();
        adopt();
        (line_.signs ? was_signed : was_unsigned) = true;
        if (happens(1)) status_.arming_state = VehicleStatus::ArmingState::kArmed;
        if (happens(2)) status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
        forget_all();
    }
    const auto seconds = static_cast<std::ptrdiff_t>((now_us_ - begin_us) / 1'000'000);
    for (const std::ptrdiff_t beats : beats_heard_) EXPECT_GE(beats, seconds - 2);
    EXPECT_TRUE(was_signed && was_unsigned) << "a key was set, and removed";
}

}  // namespace
}  // namespace stator::apps::mavlink
