// Signatures: the hash, and the gate that keeps the key. The expected bytes are pymavlink's: its
// MAVLink_heartbeat_message, packed with `signing.secret_key`, `link_id`, `timestamp` set and
// `sign_outgoing`.
#include "stator/mavlink/gate.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink/messages.hpp"

namespace stator::mav {
namespace {

using Bytes = std::vector<uint8_t>;
constexpr uint64_t kLater_us = 1'000'000;

std::string hex(std::span<const uint8_t> bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (const uint8_t byte : bytes) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15U];
    }
    return text;
}

std::string hash_of(std::string_view text) {
    Sha256 sha;
    for (const char c : text) {
        const auto byte = static_cast<uint8_t>(c);
        sha.add({&byte, 1});
    }
    return hex(sha.finish());
}

// FIPS 180-4's examples (NIST, "Examples with Intermediate Values"), and what Python's hashlib
// says.
TEST(Sha256, is_that_of_others) {
    EXPECT_EQ(hash_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hash_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hash_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(hash_of(std::string(1'000, 'a')),
              "41edece42d63e8d9bf515a9ba6932e1c20cbc9f5a5d134645adb5db1b9737ea3");
}

SigningKeyBytes key() {
    SigningKeyBytes bytes{};
    std::iota(bytes.begin(), bytes.end(), uint8_t{0});
    return bytes;
}

Bytes heartbeat(const Signed* as, uint8_t sequence = 0) {
    FrameBytes frame;
    with_payload(Heartbeat{.type = 6, .autopilot = 8, .system_status = 4, .mavlink_version = 3},
                 [&](std::span<const uint8_t> payload) {
                     frame.put(kKindOf<Heartbeat>, payload, sequence, {255, 190}, as);
                 });
    return {frame.bytes().begin(), frame.bytes().end()};
}

Bytes setup(const SigningKeyBytes& secret, uint64_t time = 7) {
    FrameBytes frame;
    SetupSigning message{.initial_timestamp = time, .target_system = 1, .target_component = 1};
    message.secret_key = secret;
    frame.put(message, 0, {255, 190});
    return {frame.bytes().begin(), frame.bytes().end()};
}

class GateTest : public ::testing::Test {
  protected:
    void use(const SigningKeyBytes& bytes) {
        ASSERT_TRUE(shared_.write({.state = SigningKey::State::kSet, .bytes = bytes}));
        gate_.follow(0);
    }
    // What goes in, read in pieces of 7 bytes.
    Bytes pass(const Bytes& line, uint64_t now_us = kLater_us) {
        std::size_t at = 0;
        Bytes passed;
        std::array<uint8_t, 7> piece{};
        while (true) {
            const std::size_t count = gate_.pass(piece, now_us, [&](uint8_t& byte) {
                if (at == line.size()) return false;
                byte = line[at++];
                return true;
            });
            passed.insert(passed.end(), piece.begin(),
                          piece.begin() + static_cast<std::ptrdiff_t>(count));
            if (count < piece.size()) return passed;
        }
    }
    // What goes out, in pieces of 5 bytes.
    Bytes sign(Bytes bytes) {
        for (std::size_t at = 0; at < bytes.size(); at += 5) {
            const std::size_t count = std::min<std::size_t>(5, bytes.size() - at);
            gate_.sign(std::span(bytes).subspan(at, count), at + count == bytes.size());
        }
        return bytes;
    }

    SharedKey shared_;
    Gate gate_{shared_, kKnown};
};

TEST_F(GateTest, signs_as_others_do) {
    use(key());
    Signed as{.link = 0, .time = 0};
    EXPECT_EQ(hex(sign(heartbeat(&as))),
              "fd09010000ffbe000000000000000608000403dab000000000000000ff842fe7c189");
    as.time = 1;
    EXPECT_EQ(hex(sign(heartbeat(&as))).substr(42), "000100000000007276082caf7c");
    as = {.link = 7, .time = 0x102030405};
    EXPECT_EQ(hex(sign(heartbeat(&as))).substr(42), "07050403020100ebe3ff0a9ac0");
}

TEST_F(GateTest, signs_each_frame_of_a_datagram_and_leaves_others_as_they_are) {
    use(key());
    const Signed as{.link = 3, .time = 99};
    const Bytes one = sign(heartbeat(&as));
    const Bytes plain = heartbeat(nullptr);
    Bytes datagram = heartbeat(&as);
    datagram.insert(datagram.end(), plain.begin(), plain.end());
    datagram.insert(datagram.end(), one.begin(), one.end());
    Bytes expected = one;
    expected.insert(expected.end(), plain.begin(), plain.end());
    expected.insert(expected.end(), one.begin(), one.end());
    EXPECT_EQ(hex(sign(datagram)), hex(expected));
}

TEST_F(GateTest, a_datagram_that_breaks_off_does_not_spoil_the_next_one) {
    use(key());
    const Signed as{.link = 3, .time = 99};
    const Bytes good = sign(heartbeat(&as));
    Bytes part = heartbeat(&as);
    part.resize(9);
    sign(part);
    EXPECT_EQ(hex(sign(heartbeat(&as))), hex(good));
}

TEST_F(GateTest, only_good_signatures_pass) {
    use(key());
    const Signed as{.link = 1, .time = 50};
    const Bytes good = sign(heartbeat(&as));
    EXPECT_EQ(pass(good), good);
    for (std::size_t i = good.size() - kSignatureBytes; i < good.size(); ++i) {
        Bytes bad = good;
        bad[i] ^= 1;
        EXPECT_TRUE(pass(bad).empty()) << i;
    }
    Bytes other = good;  // another message with the same signature, and its checksum right
    const Bytes next = heartbeat(&as, 1);
    std::copy(next.begin(), next.end() - kSignatureBytes, other.begin());
    EXPECT_TRUE(pass(other).empty());
    EXPECT_EQ(pass(heartbeat(nullptr)), heartbeat(nullptr)) << "others decide on unsigned ones";
}

TEST_F(GateTest, without_a_key_all_frames_pass_and_nothing_is_signed) {
    const Signed as{.link = 1, .time = 50};
    const Bytes frame = heartbeat(&as);
    EXPECT_EQ(pass(frame), frame);
    EXPECT_EQ(sign(frame), frame);
    EXPECT_FALSE(gate_.signs());
}

TEST_F(GateTest, a_key_that_is_lost_makes_no_signature_good) {
    const Signed as{.link = 1, .time = 50};
    use({});
    const Bytes with_zeros = sign(heartbeat(&as));
    ASSERT_TRUE(shared_.write({.state = SigningKey::State::kLost}));
    gate_.follow(0);
    EXPECT_TRUE(gate_.signs());
    EXPECT_TRUE(pass(with_zeros).empty());
    EXPECT_NE(hex(sign(heartbeat(&as))), hex(with_zeros));
}

TEST_F(GateTest, garbage_stays_outside) {
    Bytes line{1, 2, kStart, 3};
    const Bytes frame = heartbeat(nullptr);
    line.insert(line.end(), frame.begin(), frame.end());
    EXPECT_EQ(pass(line), frame);
    Bytes damaged = setup(key());
    damaged[20] ^= 1;
    EXPECT_TRUE(pass(damaged).empty()) << "nor does a key in it pass";
    EXPECT_TRUE(pass(Bytes(300, 0)).empty());
}

TEST_F(GateTest, a_key_stays_here_and_its_fingerprint_passes) {
    const Bytes passed = pass(setup(key()));
    ASSERT_EQ(passed.size(), setup(key()).size());
    Parser parser(kKnown);
    std::span<const uint8_t> bytes = passed;
    const auto frame = parser.next(bytes, 0);
    ASSERT_TRUE(frame);
    const auto message = decode<SetupSigning>(frame->payload);
    EXPECT_EQ(message.initial_timestamp, 7U);
    EXPECT_EQ(message.target_system, 1);
    // hashlib.sha256(bytes(range(32))).hexdigest()[:16]
    EXPECT_EQ(hex(message.secret_key), "630dcd2966c43366" + std::string(48, '0'));
    EXPECT_FALSE(gate_.signs());
    const auto fingerprint = std::span(message.secret_key).first(kFingerprintBytes);
    gate_.adopt(fingerprint);
    gate_.follow(kLater_us);
    EXPECT_TRUE(gate_.signs());
    const Signed as{};
    EXPECT_EQ(hex(sign(heartbeat(&as))).substr(42), "00000000000000ff842fe7c189");
}

TEST_F(GateTest, a_key_that_nobody_offered_is_not_adopted) {
    pass(setup(key()));
    const Fingerprint other{1};
    gate_.adopt(other);
    gate_.follow(kLater_us);
    EXPECT_FALSE(gate_.signs());
}

TEST_F(GateTest, a_blank_key_has_no_fingerprint_and_none_is_adopted_by_it) {
    use(key());
    const Bytes off = setup({}, 0);
    EXPECT_EQ(pass(off), off);
    gate_.adopt({});
    gate_.follow(kLater_us);
    EXPECT_FALSE(gate_.signs());
}

TEST_F(GateTest, nothing_passes_until_the_key_is_known_and_old_bytes_are_gone) {
    const Bytes frame = heartbeat(nullptr);
    shared_.expect();
    EXPECT_TRUE(pass(frame).empty());
    ASSERT_TRUE(shared_.write({}));
    gate_.follow(kLater_us);
    EXPECT_TRUE(pass(frame, kLater_us + 99'000).empty());
    EXPECT_EQ(pass(frame, kLater_us + 100'000), frame);
}

TEST_F(GateTest, half_a_frame_does_not_outlive_its_key) {
    const Bytes frame = heartbeat(nullptr);
    std::size_t at = 0;
    const auto take = [&](uint8_t& byte) {
        if (at == frame.size()) return false;
        byte = frame[at++];
        return true;
    };
    std::array<uint8_t, 8> piece{};
    EXPECT_EQ(gate_.pass(piece, kLater_us, take), piece.size());
    use(key());
    EXPECT_EQ(gate_.pass(piece, kLater_us, take), 0U);
}

TEST_F(GateTest, lines_share_the_key) {
    Gate other(shared_, kKnown);
    pass(setup(key()));
    gate_.adopt(fingerprint_of(key()));
    gate_.follow(0);
    EXPECT_FALSE(other.signs());
    other.follow(0);
    EXPECT_TRUE(other.signs());
}

}  // namespace
}  // namespace stator::mav
