// Frames are found in any stream of bytes.
#include "stator/mavlink/parser.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "mavlink/messages.hpp"

namespace stator::mav {
namespace {

using Bytes = std::vector<uint8_t>;

struct Random {
    uint64_t state = 1;
    uint32_t next() {
        state = state * 6364136223846793005U + 1442695040888963407U;
        return static_cast<uint32_t>(state >> 33);
    }
    uint32_t below(uint32_t count) { return next() % count; }
};

Bytes ping(uint32_t number) {
    FrameBytes frame;
    frame.put(Ping{.time_usec = 5, .seq = number}, static_cast<uint8_t>(number), {1, 1});
    return {frame.bytes().begin(), frame.bytes().end()};
}

// The numbers of the pings that come through, in pieces of `piece` bytes.
std::vector<uint32_t> pings_in(Parser& parser, const Bytes& bytes, std::size_t piece,
                               uint64_t now_us = 0) {
    std::vector<uint32_t> found;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
        std::span<const uint8_t> rest = bytes;
        rest = rest.subspan(at, std::min(piece, bytes.size() - at));
        while (const auto frame = parser.next(rest, now_us)) {
            if (frame->known == nullptr) continue;
            EXPECT_EQ(frame->id, Ping::kId);
            found.push_back(decode<Ping>(frame->payload).seq);
        }
    }
    return found;
}

Bytes operator+(Bytes first, const Bytes& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

TEST(Parser, FindsFramesInPiecesOfAnySize) {
    Bytes stream;
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < 300; ++i) {
        stream = stream + ping(i);
        all.push_back(i);
    }
    for (const std::size_t piece : {1U, 2U, 7U, 64U, 1000U}) {
        Parser parser(kKnown);
        EXPECT_EQ(pings_in(parser, stream, piece), all) << piece;
        EXPECT_EQ(parser.counters().skipped, 0U);
    }
}

// A start byte with the length 253, whose frame would hide the next ones.
TEST(Parser, SearchesOnBehindAFalseStart) {
    Bytes stream = {kStart, 253, 0, 0, 9, 9, 9, 4, 0, 0};
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < 20; ++i) {
        stream = stream + ping(i);
        all.push_back(i);
    }
    for (const std::size_t piece : {1U, 64U, 1000U}) {
        Parser parser(kKnown);
        EXPECT_EQ(pings_in(parser, stream, piece), all) << piece;
        EXPECT_EQ(parser.counters().damaged, 1U);
        EXPECT_EQ(parser.counters().skipped, 10U);
    }
}

TEST(Parser, SilenceEndsAFrameThatIsNotComplete) {
    const Bytes false_start = {kStart, 250, 0, 0, 9, 9, 9, 4, 0, 0};
    Parser parser(kKnown);
    EXPECT_TRUE(pings_in(parser, false_start + ping(1) + ping(2), 64, 1000).empty());
    EXPECT_TRUE(pings_in(parser, ping(3), 64, 1000 + Parser::kSilence_us - 1).empty());
    std::span<const uint8_t> none;
    std::vector<uint32_t> found;
    const uint64_t later_us = 1000 + 2 * Parser::kSilence_us;
    while (const auto frame = parser.next(none, later_us)) {
        found.push_back(decode<Ping>(frame->payload).seq);
    }
    EXPECT_EQ(found, (std::vector<uint32_t>{1, 2, 3}));
}

Bytes unknown_message(uint8_t last = 1) {
    return {kStart, 4, 0, 0, 7, 3, 9, 0xF0, 0xF0, 0xF0, kStart, 9, 0, last, 0x12, 0x34};
}

TEST(Parser, HandsOutWholeFramesOfMessagesThatItDoesNotKnow) {
    const Bytes unknown = unknown_message();
    const Bytes stream = unknown + ping(8) + unknown;
    for (const std::size_t piece : {1U, 7U, 64U}) {
        Parser parser(kKnown);
        std::vector<Bytes> found;
        for (std::size_t at = 0; at < stream.size(); at += piece) {
            std::span<const uint8_t> rest = stream;
            rest = rest.subspan(at, std::min(piece, stream.size() - at));
            while (const auto frame = parser.next(rest, 0)) {
                found.emplace_back(frame->bytes.begin(), frame->bytes.end());
                EXPECT_EQ(frame->known != nullptr, frame->id == Ping::kId);
                EXPECT_EQ(frame->id == Ping::kId || frame->id == 0xF0F0F0, true);
            }
        }
        EXPECT_EQ(found, (std::vector<Bytes>{unknown, ping(8), unknown}));
        EXPECT_EQ(parser.counters().skipped, 0U);
    }
}

// Their checksum says nothing to us: they must begin where a frame must, and have no zero at the
// end of the payload.
TEST(Parser, SkipsWhatIsHardlyAnUnknownFrame) {
    Parser parser(kKnown);
    EXPECT_EQ(pings_in(parser, Bytes{1} + unknown_message() + ping(8), 64),
              std::vector<uint32_t>{8});
    EXPECT_EQ(pings_in(parser, unknown_message(0) + ping(9), 64), std::vector<uint32_t>{9});
    Bytes of_nobody = unknown_message();
    of_nobody[5] = 0;
    EXPECT_EQ(pings_in(parser, of_nobody + ping(10), 64), std::vector<uint32_t>{10});
    // After garbage, silence is where a frame must begin.
    EXPECT_TRUE(pings_in(parser, Bytes{1}, 64).empty());
    std::span<const uint8_t> rest;
    const Bytes unknown = unknown_message();
    rest = unknown;
    const auto frame = parser.next(rest, Parser::kSilence_us);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->known, nullptr);
}

TEST(Parser, TellsWhoAFrameIsFor) {
    const auto target = [](const auto& message) {
        FrameBytes bytes;
        bytes.put(message, 0, {1, 1});
        Parser parser(kKnown);
        std::span<const uint8_t> rest = bytes.bytes();
        return target_of(*parser.next(rest, 0));
    };
    EXPECT_EQ(target(CommandLong{.target_system = 5, .target_component = 7}), (Address{5, 7}));
    EXPECT_EQ(target(ManualControl{.target = 5}), (Address{5, 0}));
    EXPECT_EQ(target(SetMode{.target_system = 5, .base_mode = 9}), (Address{5, 0}));
    EXPECT_EQ(target(Timesync{.ts1 = 3, .target_system = 5}), (Address{5, 0}));
    EXPECT_EQ(target(Timesync{.ts1 = 3}), Address{});
    EXPECT_EQ(target(Heartbeat{.type = 6}), Address{});
}

TEST(Parser, TakesSignedFramesAndRefusesOtherFlags) {
    Bytes with_signature = ping(9);
    with_signature[2] = kIsSigned;
    const std::size_t end = with_signature.size() - kCrcBytes;
    const std::span<const uint8_t> all = with_signature;
    const uint16_t crc = crc16(crc16(kCrcSeed, all.subspan(1, end - 1)), Ping::kCrcExtra);
    with_signature[end] = static_cast<uint8_t>(crc);
    with_signature[end + 1] = static_cast<uint8_t>(crc >> 8);
    with_signature.resize(with_signature.size() + kSignatureBytes, 0xFD);
    Parser parser(kKnown);
    EXPECT_EQ(pings_in(parser, with_signature + ping(10), 5), (std::vector<uint32_t>{9, 10}));
    Bytes other = ping(11);
    other[2] = 2;
    EXPECT_EQ(pings_in(parser, other + ping(12), 5), std::vector<uint32_t>{12});
}

TEST(Parser, LosesNoFrameToGarbageBetweenFrames) {
    Random random;
    Parser parser(kKnown);
    uint64_t now_us = 0;
    uint32_t found = 0;
    constexpr uint32_t kFrames = 20'000;
    for (uint32_t i = 0; i < kFrames; ++i) {
        Bytes stream = ping(i);
        if (i % 20 == 0) {
            Bytes garbage(random.below(300));
            for (uint8_t& byte : garbage) {
                byte = random.below(4) == 0 ? kStart : static_cast<uint8_t>(random.next());
            }
            stream = garbage + stream;
        }
        now_us += 20'000;
        found += static_cast<uint32_t>(pings_in(parser, stream, 64, now_us).size());
    }
    std::span<const uint8_t> none;
    while (parser.next(none, now_us + Parser::kSilence_us)) ++found;
    EXPECT_EQ(found, kFrames);
}

// Bytes of four kinds: any, starts and zeros, whole frames, frames with one bit flipped. Whatever a
// frame says, its payload is inside the parser, and every message decodes from it.
TEST(Parser, EndsWithAnyBytes) {
    Random random;
    Parser parser(kKnown);
    uint64_t frames = 0;
    uint64_t sum = 0;
    constexpr std::size_t kBytes = 20'000'000;
    std::array<uint8_t, 64> chunk{};
    uint64_t now_us = 0;
    for (std::size_t done = 0; done < kBytes; done += chunk.size()) {
        const uint32_t kind = random.below(4);
        const Bytes frame = ping(random.next());
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            chunk[i] = kind < 2 ? static_cast<uint8_t>(random.next()) : frame[i % frame.size()];
            if (kind == 1) chunk[i] = chunk[i] < 100 ? kStart : static_cast<uint8_t>(chunk[i] % 2);
        }
        if (kind == 3) chunk[random.below(64)] ^= static_cast<uint8_t>(1U << random.below(8));
        now_us += random.below(100) == 0 ? 300'000 : 1000;
        std::span<const uint8_t> rest = chunk;
        while (const auto found = parser.next(rest, now_us)) {
            ++frames;
            for_every_message([&]<class Message>(Message*) {
                if (Message::kId != found->id) return;
                const auto message = decode<Message>(found->payload);
                FrameBytes again;
                again.put(message, found->sequence, found->source);
                sum += again.bytes().size();
            });
        }
    }
    EXPECT_GT(frames, kBytes / 200);
    EXPECT_GT(parser.counters().damaged, 0U);
    EXPECT_GT(sum, 0U);
}

}  // namespace
}  // namespace stator::mav
