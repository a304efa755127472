// Files are listed, opened and read as stations do it.
#include "file_transfer.hpp"

#include <string_view>

#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

constexpr uint8_t kTerminate = 1;
constexpr uint8_t kReset = 2;
constexpr uint8_t kList = 3;
constexpr uint8_t kOpen = 4;
constexpr uint8_t kRead = 5;
constexpr uint8_t kWrite = 7;
constexpr uint8_t kCrc = 14;
constexpr uint8_t kBurst = 15;
constexpr uint8_t kListWithTimes = 16;
constexpr uint8_t kDone = 128;
constexpr uint8_t kRefused = 129;

struct Reply {
    uint16_t sequence;
    uint8_t session;
    uint8_t opcode;
    uint8_t answers;
    bool is_last;
    uint32_t offset;
    std::vector<uint8_t> data;

    bool operator==(const Reply&) const = default;
    int error() const { return opcode == kRefused && data.size() == 1 ? data[0] : 0; }
    uint32_t number() const {
        uint32_t value = 0;
        if (data.size() == sizeof value) std::memcpy(&value, data.data(), sizeof value);
        return value;
    }
    std::string text() const { return {data.begin(), data.end()}; }
};

class FileTransferTest : public MavlinkTest {
  protected:
    static constexpr std::string_view kPack = "@PARAM/param.pck";
    static constexpr mav::Address kOther{245, 190};

    FileTransferTest() {
        for (unsigned i = 0; i < 1000; ++i) pack_.push_back(static_cast<uint8_t>(i * 7));
        logs_ = {std::vector<uint8_t>(5000, 3)};
    }

    struct Wanted {
        uint8_t opcode;
        std::string_view path{};
        uint32_t offset = 0;
        uint8_t size = 0;
        uint8_t session = 0;
    };
    void ask(const Wanted& wanted, mav::Address from = kGround, unsigned line = 0) {
        mav::FileTransferProtocol message{.target_system = 1};
        ++sequence_;
        std::memcpy(message.payload.data(), &sequence_, 2);
        message.payload[2] = wanted.session;
        message.payload[3] = wanted.opcode;
        message.payload[4] =
            wanted.path.empty() ? wanted.size : static_cast<uint8_t>(wanted.path.size());
        std::memcpy(&message.payload[8], &wanted.offset, 4);
        std::ranges::copy(wanted.path, &message.payload[12]);
        send(message, line, from);
    }
    std::vector<Reply> replies(unsigned line = 0) {
        std::vector<Reply> found;
        for (const auto& message : heard<mav::FileTransferProtocol>(line)) {
            const auto& p = message.payload;
            Reply reply{.sequence = static_cast<uint16_t>(p[0] | p[1] << 8),
                        .session = p[2],
                        .opcode = p[3],
                        .answers = p[5],
                        .is_last = p[6] != 0,
                        .offset = 0,
                        .data = {p.begin() + 12, p.begin() + 12 + p[4]}};
            std::memcpy(&reply.offset, &p[8], 4);
            found.push_back(reply);
        }
        return found;
    }
    // The only reply to one request.
    Reply reply_to(const Wanted& wanted, mav::Address from = kGround) {
        forget();
        ask(wanted, from);
        run(1.0);
        const auto all = replies();
        EXPECT_EQ(all.size(), 1U);
        if (all.empty()) return {};
        EXPECT_EQ(all[0].sequence, static_cast<uint16_t>(sequence_ + 1));
        EXPECT_EQ(all[0].session, wanted.session);
        EXPECT_EQ(all[0].answers, wanted.opcode);
        return all[0];
    }
    std::vector<std::string> list(std::string_view path) {
        std::vector<std::string> names;
        for (uint32_t i = 0; i < 20; ++i) {
            const Reply reply = reply_to({kList, path, i});
            if (reply.opcode != kDone) {
                EXPECT_EQ(reply.error(), 6);
                return names;
            }
            EXPECT_EQ(reply.data.back(), 0);
            names.emplace_back(reply.data.begin(), reply.data.end() - 1);
        }
        return names;
    }

    uint16_t sequence_ = 65530;  // it wraps
};

TEST_F(FileTransferTest, ListsTheTreeAndNothingElse) {
    using Names = std::vector<std::string>;
    const Names root{"D@PARAM", "Detc", "Dlog"};
    for (const auto* path : {"/", ".", "//"}) EXPECT_EQ(list(path), root) << path;
    EXPECT_EQ(list("@PARAM"), (Names{"Fparam.pck\t1000"}));
    EXPECT_EQ(list("/etc"), (Names{"Fgeneral.json\t4", "Fparameters.json.xz\t500"}));
    EXPECT_EQ(list("/log/"), (Names{"F0.ulg\t5000"}));
    for (const auto* path : {"/..", "/etc/..", "/home", "log/../etc", "/etc/general.json"}) {
        EXPECT_EQ(reply_to({kList, path}).error(), 10) << path;
    }
}

TEST_F(FileTransferTest, ReadsAFilePieceByPiece) {
    const Reply opened = reply_to({kOpen, "/@PARAM/param.pck", 0, 0, 7});
    EXPECT_EQ(opened.opcode, kDone);
    EXPECT_EQ(opened.number(), 1000U);
    std::vector<uint8_t> read;
    for (uint32_t at = 0; at < 1000; at += 239) {
        const Reply piece = reply_to({kRead, {}, at, 239, 7});
        EXPECT_EQ(piece.opcode, kDone);
        EXPECT_EQ(piece.offset, at);
        read.insert(read.end(), piece.data.begin(), piece.data.end());
    }
    EXPECT_EQ(read, pack_);
    EXPECT_EQ(reply_to({kRead, {}, 10, 80, 7}).data.size(), 80U);
    EXPECT_EQ(reply_to({kRead, {}, 1000, 239, 7}).error(), 6);
    EXPECT_EQ(reply_to({kRead, {}, UINT32_MAX, 239, 7}).error(), 6);
    EXPECT_EQ(reply_to({kRead, {}, 0, 0, 7}).error(), 3);
    EXPECT_EQ(reply_to({kRead, {}, 0, 240, 7}).error(), 3);
    EXPECT_EQ(reply_to({kRead, {}, 0, 239, 8}).error(), 4);
    EXPECT_EQ(reply_to({kRead, {}, 0, 239, 7}, kOther).error(), 4) << "another station's session";
    EXPECT_EQ(reply_to({kTerminate, {}, 0, 0, 7}).opcode, kDone);
    EXPECT_EQ(reply_to({kTerminate, {}, 0, 0, 7}).opcode, kDone);
    EXPECT_EQ(reply_to({kRead, {}, 0, 239, 7}).error(), 4);
}

TEST_F(FileTransferTest, TheFileOfParametersHasOptions) {
    for (const auto* path :
         {"@PARAM/param.pck?withdefaults=1", "@PARAM/param.pck?start=1&count=2"}) {
        EXPECT_EQ(reply_to({kOpen, path}).number(), 1000U) << path;
    }
    for (const auto* path : {"@PARAM/param.pck?start=70000", "@PARAM/param.pck?start=",
                             "@PARAM/param.pck?count=-1", "@PARAM/other", "param.pck"}) {
        EXPECT_EQ(reply_to({kOpen, path}).error(), 10) << path;
    }
}

TEST_F(FileTransferTest, ABurstHasAllPiecesAndSaysWhichIsTheLast) {
    reply_to({kOpen, kPack});
    forget();
    ask({kBurst, {}, 200, 80});
    run(1.0);
    const auto all = replies();
    ASSERT_EQ(all.size(), 10U);
    std::vector<uint8_t> read;
    for (unsigned i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].opcode, kDone);
        EXPECT_EQ(all[i].answers, kBurst);
        EXPECT_EQ(all[i].sequence, static_cast<uint16_t>(sequence_ + 1 + i));
        EXPECT_EQ(all[i].offset, 200 + 80 * i);
        EXPECT_EQ(all[i].is_last, i == 9);
        read.insert(read.end(), all[i].data.begin(), all[i].data.end());
    }
    EXPECT_EQ(read, std::vector<uint8_t>(pack_.begin() + 200, pack_.end()));
    EXPECT_EQ(reply_to({kBurst, {}, 1000, 80}).error(), 6);
}

TEST_F(FileTransferTest, ALongBurstIsEndedAndAskedForAgain) {
    pack_.assign(30'000, 1);
    reply_to({kOpen, kPack});
    forget();
    ask({kBurst, {}, 0, 239});
    run(5.0);
    const auto all = replies();
    ASSERT_EQ(all.size(), FileTransfer::kBurstPieces);
    EXPECT_TRUE(all.back().is_last);
    EXPECT_FALSE(all[98].is_last);
}

TEST_F(FileTransferTest, AReadInABurstIsAnsweredAndTheBurstGoesOn) {
    pack_.assign(10'000, 1);
    reply_to({kOpen, kPack});
    forget();
    ask({kBurst, {}, 0, 239});
    run(0.1);
    ask({kRead, {}, 17, 20});
    run(3.0);
    unsigned reads = 0;
    std::size_t bytes = 0;
    for (const Reply& reply : replies()) {
        if (reply.answers == kRead) ++reads;
        if (reply.answers == kBurst) bytes += reply.data.size();
    }
    EXPECT_EQ(reads, 1U);
    EXPECT_EQ(bytes, 10'000U);
    ask({kBurst, {}, 0, 239});
    run(0.1);
    reply_to({kTerminate});
    run(1.0);
    EXPECT_EQ(replies().size(), 1U) << "a burst ends with its session";
}

TEST_F(FileTransferTest, ContentsThatChangeEndTheReading) {
    reply_to({kOpen, kPack});
    EXPECT_EQ(reply_to({kRead, {}, 0, 10}).opcode, kDone);
    ++version_;
    EXPECT_EQ(reply_to({kRead, {}, 0, 10}).error(), 1);
    EXPECT_EQ(reply_to({kBurst, {}, 0, 10}).error(), 1);
    reply_to({kOpen, kPack});
    EXPECT_EQ(reply_to({kRead, {}, 0, 10}).opcode, kDone);
}

TEST_F(FileTransferTest, TellsTheChecksumOfAFile) {
    // "123456789" of every list of checksums: without the inversions it is this.
    pack_ = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(reply_to({kCrc, kPack}).number(), 0x2DFD2D88U);
    logs_[0].resize(239 * 2);  // the last piece is full
    EXPECT_EQ(reply_to({kCrc, "/log/0.ulg"}).data.size(), 4U);
    EXPECT_EQ(reply_to({kCrc, "/log/1.ulg"}).error(), 10);
}

TEST_F(FileTransferTest, NothingIsWritten) {
    for (uint8_t opcode = 6; opcode <= 13; ++opcode) {
        EXPECT_EQ(reply_to({opcode, "/etc/general.json"}).error(), 9) << int{opcode};
    }
    reply_to({kOpen, "/etc/general.json"});
    EXPECT_EQ(reply_to({kWrite, "data"}).error(), 9);
    EXPECT_EQ(reply_to({kListWithTimes, "/"}).error(), 7);
    EXPECT_EQ(reply_to({200, "/"}).error(), 7);
}

TEST_F(FileTransferTest, SessionsAreFew) {
    for (uint8_t session = 0; session < FileTransfer::kSessions; ++session) {
        EXPECT_EQ(reply_to({kOpen, kPack, 0, 0, session}).opcode, kDone);
    }
    EXPECT_EQ(reply_to({kOpen, kPack, 0, 0, 100}).error(), 5);
    EXPECT_EQ(reply_to({kOpen, kPack, 0, 0, 3}).opcode, kDone) << "its own is opened again";
    run(4.0);
    EXPECT_EQ(reply_to({kRead, {}, 0, 10, 1}).opcode, kDone);  // this one is not idle
    run(4.0);
    EXPECT_EQ(reply_to({kOpen, kPack, 0, 0, 100}).opcode, kDone);
    EXPECT_EQ(reply_to({kRead, {}, 0, 10, 1}).opcode, kDone);
    EXPECT_EQ(reply_to({kRead, {}, 0, 10, 0}).error(), 4);
    EXPECT_EQ(reply_to({kReset}).opcode, kDone);
    EXPECT_EQ(reply_to({kRead, {}, 0, 10, 1}).error(), 4);
}

TEST_F(FileTransferTest, TwoStationsWithTheSameNumberReadTwoFiles) {
    reply_to({kOpen, kPack});
    reply_to({kOpen, "/log/0.ulg"}, kOther);
    EXPECT_EQ(reply_to({kRead, {}, 1, 1}).data, (std::vector<uint8_t>{7}));
    EXPECT_EQ(reply_to({kRead, {}, 1, 1}, kOther).data, (std::vector<uint8_t>{3}));
    reply_to({kReset}, kOther);
    EXPECT_EQ(reply_to({kRead, {}, 1, 1}).data, (std::vector<uint8_t>{7}));
}

TEST_F(FileTransferTest, ARepeatedRequestHasTheSameAnswer) {
    reply_to({kOpen, kPack});
    const Reply first = reply_to({kRead, {}, 5, 9});
    --sequence_;
    EXPECT_EQ(reply_to({kRead, {}, 5, 9}), first);
}

TEST_F(FileTransferTest, ABoardWithoutLogsHasNone) {
    reads_logs_ = false;
    EXPECT_EQ(reply_to({kList, "/log"}).error(), 6);
    EXPECT_EQ(reply_to({kOpen, "/log/0.ulg"}).error(), 10);
    EXPECT_EQ(reply_to({kOpen, "/etc/general.json"}).number(), 4U) << "and goes on";
}

TEST_F(FileTransferTest, ForOthersNothingIsDone) {
    mav::FileTransferProtocol message{.target_system = 2};
    message.payload[3] = kList;
    send(message);
    message.target_system = 1;
    message.target_component = 100;
    send(message);
    run(0.5);
    EXPECT_TRUE(replies().empty());
}

TEST_F(FileTransferTest, NamesTheFileThatDescribesAllParameters) {
    send_command(512, {397, 0, 0, 0, 0, 0, 0});
    run(0.1);
    EXPECT_EQ(results(512), (std::vector{0}));
    const auto told = heard<mav::ComponentMetadata>();
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].file_crc, 0x1234U);
    EXPECT_STREQ(told[0].uri.data(), "mftp://etc/general.json");
    EXPECT_EQ(reply_to({kOpen, "etc/general.json"}).number(), 4U);
}

}  // namespace
}  // namespace stator::apps::mavlink
