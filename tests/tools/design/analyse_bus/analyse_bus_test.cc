// SPDX-License-Identifier: BSD-2-Clause
// mlccactl analyse-bus as a user and a script see it: tables.
#include <algorithm>

#include "tests/tools/design/analyse_bus/bus_test.hpp"

namespace mlcca {
namespace {

/// The example of Davis et al. 2007.
constexpr const char* kDavis =
    "C,3,0,7,3500,3250,0\n"
    "A,1,0,7,2500,2500,0\n"
    "B,2,0,7,3500,3250,0\n";

TEST_F(AnalyseBusTest, AMissedDeadlineIsExitStatusOneAndMessagesAreInTheOrderOfIdentifiers) {
  const auto done = slow(table(kDavis), {"--json"});
  EXPECT_EQ(done.status, 1);
  const Json out = bus_of(done.out);
  EXPECT_EQ(out["bitrate"], 125000);
  EXPECT_FALSE(out["schedulable"].get<bool>());
  // 1 ms in 2.5 ms, and twice 1 ms in 3.5 ms
  EXPECT_NEAR(out["bus_load"].get<double>(), 0.4 + 2.0 / 3.5, 2e-6);
  ASSERT_EQ(out["messages"].size(), 3U);
  const std::vector<std::string> names = {"A", "B", "C"};
  const std::vector<double> responses = {2000, 3000, 3500};
  const std::vector<double> slacks = {500, 250, -250};
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& m = out["messages"][i];
    EXPECT_EQ(m["name"], names[i]);
    EXPECT_EQ(m["id"], i + 1);
    EXPECT_EQ(m["frame_time_us"], 1000);
    EXPECT_EQ(m["response_us"], responses[i]);
    EXPECT_EQ(m["slack_us"], slacks[i]);
    EXPECT_EQ(m["schedulable"], i < 2);
  }
}

TEST_F(AnalyseBusTest, TheTableShowsTheSame) {
  const auto done = slow(table(kDavis));
  EXPECT_EQ(done.status, 1);
  EXPECT_LT(done.out.find("A  "), done.out.find("B  "));
  EXPECT_NE(done.out.find("3500.000"), std::string::npos);
  EXPECT_NE(done.out.find("-250.000"), std::string::npos);
  EXPECT_NE(done.out.find("late"), std::string::npos);
  EXPECT_NE(done.out.find("Bus load 97.14 %"), std::string::npos);
}

TEST_F(AnalyseBusTest, AllInTimeIsExitStatusZero) {
  EXPECT_EQ(slow(table("A,1,0,7,2500,2500,0\n")).status, 0);
}

TEST_F(AnalyseBusTest, AnIdentifierOf11BitsGoesBeforeOneOf29WithTheSameStart) {
  const auto done = slow(
      table("far,0x4000000,true,8,100000,100000,0\nnear,0x100,0,8,100000,100000,0\n"), {"--json"});
  const Json out = bus_of(done.out);
  EXPECT_EQ(out["messages"][0]["name"], "near");
  EXPECT_EQ(out["messages"][1]["name"], "far");
  // 160 bits of 8 us; 135 bits go before
  EXPECT_EQ(out["messages"][1]["frame_time_us"], 1280);
  EXPECT_EQ(out["messages"][1]["response_us"], 1280 + 1080);
}

TEST_F(AnalyseBusTest, JsonSaysWhichFormItHas) {
  const auto done = slow(table("A,1,0,7,1000,1000,0\n"), {"--json"});
  EXPECT_TRUE(done.out.starts_with("{\"version\":1,\"schedulable\":")) << done.out;
}

TEST_F(AnalyseBusTest, UnboundedIsNull) {
  const auto done = slow(table("A,1,0,7,1000,1000,0\nB,2,0,7,5000,5000,0\n"), {"--json"});
  EXPECT_EQ(done.status, 1);
  EXPECT_TRUE(bus_of(done.out)["messages"][1]["response_us"].is_null());
}

TEST_F(AnalyseBusTest, UnknownSendersBackgroundAndFaultsCount) {
  const auto path = table("A,1,0,7,100000,100000,0\n");
  const auto response = [&](const std::vector<std::string>& options) {
    auto all = options;
    all.emplace_back("--json");
    return bus_of(slow(path, all).out)["messages"][0]["response_us"].get<double>();
  };
  EXPECT_EQ(response({}), 1000);
  EXPECT_EQ(response({"--unknown-senders"}), 1000 + 1280);
  // Until its start at t others take 1280 us and a tenth of t: t = 1280 + t / 10.
  EXPECT_NEAR(response({"--background-load", "0.1"}), 1000 + 1280 / 0.9, 0.01);
  // One error frame (31 bits) that was on the bus, one more and a spoilt frame.
  EXPECT_EQ(response({"--faults", "1", "--fault-interval-ms", "50"}), 248 + 248 + 1000 + 1000);
}

TEST_F(AnalyseBusTest, AnOrderIsFoundWhereThereIsOne) {
  const auto path =
      table("slow,1,0,7,20000,20000,0\nfast,2,0,7,5000,2000,0\nlast,3,0,7,20000,20000,0\n");
  const auto given = slow(path, {"--json", "--assign"});
  EXPECT_EQ(given.status, 1);
  EXPECT_EQ(bus_of(given.out)["assignment"][0], "fast");
  EXPECT_NE(slow(path, {"--assign"}).out.find("deadlines are met:\n  fast\n"), std::string::npos);
  const auto none =
      slow(table("a,1,0,7,20000,1500,0\nb,2,0,7,20000,1500,0\n"), {"--json", "--assign"});
  EXPECT_TRUE(bus_of(none.out)["assignment"].is_null());
  EXPECT_FALSE(bus_of(none.out).contains("assignment_may_exist"));
  const auto fragments = slow(file("fragments.csv",
                                   "name,id,extended,bytes,period_us,deadline_us,frames\n"
                                   "a,1,0,7,20000,1900,2\nb,2,0,7,20000,1900,1\n"),
                              {"--assign"});
  EXPECT_NE(fragments.out.find("One may exist: "), std::string::npos) << fragments.out;
}

TEST_F(AnalyseBusTest, ACommentThatCutsALineIsNamed) {
  EXPECT_NE(slow(table("a#1,1,0,7,20000,1500,0\n")).error.find("(what follows a # is a comment)"),
            std::string::npos);
  EXPECT_EQ(slow(table("a,1,0,7\n")).error.find('#'), std::string::npos);
}

TEST_F(AnalyseBusTest, TablesMayHaveCommentsBlankLinesAnyOrderAndFurtherColumns) {
  const auto path = file("free.csv",
                         "\xef\xbb\xbf# a bus\r\n\r\n"
                         "id, name ,bytes,extended,jitter_us,deadline_us,period_us,fd,frames\r\n"
                         "0x10, \"a, b\", 64, false, 0.5, 9000.25, 10000, 1, 2\r\n");
  const auto done = analyse(path, {"--bitrate", "500000", "--data-bitrate", "2000000", "--json"});
  ASSERT_EQ(done.status, 0) << done.error << done.out;
  const Json m = bus_of(done.out)["messages"][0];
  EXPECT_EQ(m["name"], "a, b") << "a comma in quotes is one of the name";
  EXPECT_EQ(m["id"], 16);
  EXPECT_EQ(m["frames"], 2);
  EXPECT_EQ(m["jitter_us"], 0.5);
  EXPECT_EQ(m["deadline_us"], 9000.25);
}

TEST_F(AnalyseBusTest, EveryBadLineIsNamedAndNothingElseIsSaid) {
  struct Case {
    const char* line;
    const char* text;
  };
  const std::vector<Case> cases = {
      {"a,0x800,0,8,1000,1000,0", "id '0x800': must be a whole number from 0 to 2047"},
      {"a,0x20000000,1,8,1000,1000,0", "id '0x20000000'"},
      {"a,1,2,8,1000,1000,0", "extended '2': must be 0, 1, true or false"},
      {"a,1,0,9,1000,1000,0", "bytes '9': must be a whole number from 0 to 8"},
      {"a,1,0,8,0,1000,0", "period_us '0': must be 0.001 (1 ns) or more"},
      {"a,1,0,8,1000,soon,0", "deadline_us 'soon'"},
      {"a,1,0,8,1000,1000,-1", "jitter_us '-1'"},
      {"a,1,0,8,1000,1000", "6 values: must be 7"},
      {"a;1;0;8;1000;1000;0",
       "1 value: must be 7, one for each column of the header (the columns of the header are "
       "separated by ',', those of this line by ';')"},
      {",1,0,8,1000,1000,0", "name is empty"},
      {"a,1x,0,8,1000,1000,0", "id '1x'"},
  };
  std::string lines = "good,1,0,8,10000,10000,0\n";
  for (const Case& c : cases) lines += std::string(c.line) + "\n";
  const auto path = table(lines);
  const auto done = slow(path);
  EXPECT_EQ(done.status, 2);
  EXPECT_EQ(done.out, "");
  for (std::size_t i = 0; i < cases.size(); ++i)
    EXPECT_NE(done.error.find(path + ":" + std::to_string(i + 3) + ": " + cases[i].text),
              std::string::npos)
        << cases[i].line << '\n'
        << done.error;
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(done.error, '\n')), cases.size());
  const auto json = slow(path, {"--json"});
  EXPECT_EQ(json.status, 2);
  EXPECT_EQ(Json::parse(json.out)["error"]["details"].size(), cases.size() - 1);
}

TEST_F(AnalyseBusTest, HeadersThatDoNotServeAreNamed) {
  for (const char* header :
       {"", "name,id\n", "name,id,extended,bytes,period_us,deadline_us,colour\n"}) {
    const auto path = file("head.csv", header);
    const auto done = slow(path);
    EXPECT_EQ(done.status, 2) << header;
    EXPECT_NE(done.error.find(path + ":1: "), std::string::npos) << done.error;
  }
  EXPECT_EQ(slow(table("")).status, 2);  // no messages
}

TEST_F(AnalyseBusTest, CommandLinesThatCannotBeUsed) {
  const auto path = table(kDavis);
  EXPECT_EQ(analyse(path).status, 2);  // no bit rate
  EXPECT_NE(analyse(path).error.find("--bitrate"), std::string::npos);
  EXPECT_EQ(analyse(path, {"--bitrate", "0"}).status, 2);
  EXPECT_EQ(slow(path, {"--faults", "1"}).status, 2);
  EXPECT_EQ(slow(path, {"--fault-interval-ms", "1"}).status, 2);
  EXPECT_EQ(slow(path, {"--faults", "1", "--fault-interval-ms", "nan"}).status, 2);
  EXPECT_EQ(slow(path, {"--background-load", "2"}).status, 2);
  EXPECT_EQ(slow(path, {"--network", "a"}).status, 2);
  EXPECT_EQ(slow(path, {"--data-bitrate", "1000"}).status, 2);
  EXPECT_EQ(slow(path + ".none").status, 2);
  EXPECT_NE(slow(path + ".none").error.find("No such file"), std::string::npos);
}

TEST_F(AnalyseBusTest, TheDataPhaseIsAsFastAsADescriptionMayStateIt) {
  const auto path = table("a,1,0,8,10000,10000,0\n");
  const auto with = [&](const char* rate) {
    return analyse(path, {"--bitrate", "500k", "--data-bitrate", rate});
  };
  EXPECT_EQ(with("8M").status, 0) << with("8M").error;
  const auto refused = with("8000001");
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.error.find("--data-bitrate: '8000001': a CAN bus has at most 8 Mbit/s"),
            std::string::npos)
      << refused.error;
  EXPECT_EQ(with("12M").status, 2);
}

TEST_F(AnalyseBusTest, WhoLeavesOthersUnboundedIsNamed) {
  const auto path = table(
      "first,1,0,8,10000,10000,0\nfull,2,0,8,1200,1200,0\n"
      "last,3,0,8,10000,10000,0\n");
  const auto done = slow(path, {"--json"});
  EXPECT_EQ(done.status, 1);
  const Json out = bus_of(done.out);
  EXPECT_NE(out["not_bounded"].get<std::string>().find("With full the messages up to there take"),
            std::string::npos)
      << out;
  EXPECT_EQ(out["messages"][0]["verdict"], "met");
  EXPECT_EQ(out["messages"][2]["verdict"], "not-bounded");
  const auto jitter = table("a,1,0,8,10000,10000,2000000000\nb,2,0,8,10000,10000,0\n");
  const auto refused = slow(jitter);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.error.find(jitter + ":2: jitter_us '2000000000': must be at most 1099511627"),
            std::string::npos)
      << refused.error;
}

TEST_F(AnalyseBusTest, ColumnsMayBeLeftOutAndSeparatedAsElsewhere) {
  const auto expected = slow(table("A,1,0,7,2500,2500,0\n"), {"--json"}).out;
  for (const char* text : {"Name;ID;Extended;Bytes;Period_us\nA;1;0;7;2500\n",
                           "name\tid\textended\tbytes\tperiod_us\tjitter_us\nA\t1\t0\t7\t2500\t\n",
                           "NAME|ID|EXTENDED|BYTES|PERIOD_US\nA|1|0|7|2500\n",
                           "name;id;extended;bytes;period_us;jitter_us\nA;1;0;7;2500,0;0,0\n",
                           "name,id,extended,bytes,period_us # head\nA,1,0,7,2500 # the only one\n",
                           "name,id,extended,bytes,period_us,deadline_us\n\"A\",1,0,7,2500,\n"}) {
    const auto done = slow(file("as.csv", text), {"--json"});
    EXPECT_EQ(done.out, expected) << text << done.error;
  }
}

/// A line or a cell with the separator of another table is named for it.
TEST_F(AnalyseBusTest, ASeparatorThatIsNotThatOfTheHeaderIsNamed) {
  struct Case {
    std::string separator;
    const char* line;
    std::vector<const char*> texts;
  };
  const std::vector<Case> cases = {
      {",",
       "V;0x10;0;8;1000,5;1000",
       {"2 values: must be 6, one for each column of the header (the columns of the header are "
        "separated by ',', those of this line by ';')"}},
      {";",
       "V,0x10,0,8,1000;1000",
       {"2 values: must be 6, one for each column of the header (this line has ',' too, and the "
        "columns of the header are separated by ';')"}},
      {",",
       "V,0x10,0,8,1000,5,1000",
       {"7 values: must be 6, one for each column of the header (columns are separated by ',', so "
        "a number must have a decimal point)"}},
      {",",
       "V,0x10,0,8,\"1000,5\",1000",
       {"period_us '1000,5': must have a decimal point: columns are separated by ','"}},
      {";",
       "V;0x10;0;8,0;1000;1000",
       {"bytes '8,0': must be a whole number from 0 to 8, decimal or 0x… (where columns are "
        "separated by ';', ',' is a decimal comma)"}},
      {",",
       "V,0x10;0,0,8,1000;3,1000",
       {"id '0x10;0': must be a whole number from 0 to 2047, decimal or 0x… (the columns of the "
        "header are separated by ',', not by ';')",
        "period_us '1000;3': must be a number of microseconds (the columns of the header are "
        "separated by ',', not by ';')"}},
      {"\t",
       "V;0x10;0;8;1000;1000",
       {"1 value: must be 6, one for each column of the header (the columns of the header are "
        "separated by tab, those of this line by ';')"}},
  };
  for (const Case& c : cases) {
    std::string header = "name,id,extended,bytes,period_us,deadline_us\n";
    for (char& one : header)
      if (one == ',') one = c.separator.front();
    const auto path = file("mixed.csv", header + c.line + "\n");
    const auto done = slow(path);
    EXPECT_EQ(done.status, 2) << done.out;
    for (const char* text : c.texts)
      EXPECT_TRUE(done.error.contains(path + ":2: " + text + "\n")) << c.line << done.error;
  }
  const auto head = slow(file("head.csv", "name;id;extended,bytes;period_us\nV;16;0;8;1000\n"));
  EXPECT_TRUE(head.error.contains(
      "head.csv:1: there are no columns extended and bytes; unknown column 'extended,bytes' (this "
      "line has ';' and ',': all columns must be separated by one)"))
      << head.error;
}

TEST_F(AnalyseBusTest, QuotesInQuotesAreTwo) {
  const auto done = slow(table("\"5\"\" wheel # 1, left\",1,0,7,2500,2500,0 # a\n"), {"--json"});
  ASSERT_EQ(done.status, 0) << done.error;
  EXPECT_EQ(bus_of(done.out)["messages"][0]["name"], "5\" wheel # 1, left");
  const auto path = table("\"open,1,0,7,2500,2500,0\n");
  EXPECT_NE(slow(path).error.find(path + ":2: quotes are not right"), std::string::npos);
}

TEST_F(AnalyseBusTest, AHeaderThatIsWrongIsOneMessage) {
  const auto done = slow(file("head.csv", "name,colour,id,shape\nx,1,2,3\n"));
  EXPECT_EQ(done.status, 2);
  EXPECT_EQ(std::ranges::count(done.error, '\n'), 1) << done.error;
  for (const char* word : {"extended", "bytes", "period_us", "'colour'", "'shape'"})
    EXPECT_NE(done.error.find(word), std::string::npos) << done.error;
}

TEST_F(AnalyseBusTest, OfAKindOfProblemTheFirstTwentyAreSaid) {
  std::string lines;
  for (int i = 0; i < 500; ++i) lines += "m" + std::to_string(i) + ",1,0,9,1000,1000,0\n";
  lines += "n,1,0,8,soon,1000,0\n";
  const auto done = slow(table(lines));
  EXPECT_EQ(done.status, 2);
  EXPECT_EQ(std::ranges::count(done.error, '\n'), 22) << done.error;
  EXPECT_NE(done.error.find("and 480 more of this kind: bytes"), std::string::npos) << done.error;
  EXPECT_NE(done.error.find("period_us 'soon'"), std::string::npos);
}

TEST_F(AnalyseBusTest, BitRatesHaveUnitsAndALimit) {
  const auto path = table(kDavis);
  EXPECT_EQ(analyse(path, {"--bitrate", "125k"}).out, slow(path).out);
  EXPECT_EQ(analyse(path, {"--bitrate", "0.125 Mbit/s"}).out, slow(path).out);
  for (const char* rate : {"1000001", "2M", "500x", "k", "-1"}) {
    const auto done = analyse(path, {"--bitrate", rate});
    EXPECT_EQ(done.status, 2) << rate;
    EXPECT_NE(done.error.find("--bitrate"), std::string::npos) << done.error;
  }
  EXPECT_EQ(analyse(path, {"--bitrate", "1M", "--data-bitrate", "8M"}).status, 0);
}

TEST_F(AnalyseBusTest, FramesOfANodeMayWaitInOneFifo) {
  const auto path =
      file("node.csv",
           "name,id,extended,bytes,period_us,node\nA,1,0,7,100000,\nB,2,0,7,100000,door\n"
           "C,3,0,7,100000,\nD,4,0,7,100000,door\n");
  const auto done = slow(path, {"--json"});
  ASSERT_EQ(done.status, 0) << done.error << done.out;
  const Json out = bus_of(done.out);
  // Blocked by nothing below D; D came first, and what wins against D goes before that: A, C.
  EXPECT_EQ(message_of(out, "B")["response_us"], 4000);
  EXPECT_EQ(message_of(out, "B")["node"], "door");
  EXPECT_EQ(message_of(out, "B")["queue"]["frames"], 2);
  EXPECT_EQ(message_of(out, "A")["response_us"], 2000);
}

TEST_F(AnalyseBusTest, ATableInUtf16IsNamed) {
  for (const std::string mark : {"\xff\xfe", "\xfe\xff"}) {
    const auto done = slow(file("wide.csv", mark + std::string("n\0a\0m\0e\0", 8)));
    EXPECT_EQ(done.status, 2);
    EXPECT_NE(done.error.find(":1: the table is UTF-16"), std::string::npos) << done.error;
  }
}

TEST_F(AnalyseBusTest, NamesTheMessageOfWhichTooManyEventsWaitAtOnce) {
  const auto path = table(
      "a,0x1,0,7,50000,,\n"
      "b,0x2,0,7,50000,,1000000000\n"
      "c,0x3,0,7,50000,,\n");
  EXPECT_NE(
      slow(path).out.find(
          "\nb has so much jitter that 20001 of its events may wait at once, and at most 4096 "
          "in a row are analysed.\n"),
      std::string::npos)
      << slow(path).out;
}

TEST_F(AnalyseBusTest, SpreadsheetsWriteTrueInCapitals) {
  const auto expected = slow(table("A,1,true,7,2500,2500,0\n"), {"--json"}).out;
  for (const char* yes : {"TRUE", "True", "1"})
    EXPECT_EQ(slow(table("A,1," + std::string(yes) + ",7,2500,2500,0\n"), {"--json"}).out, expected)
        << yes;
  EXPECT_TRUE(slow(table("A,1,WAHR,7,2500,2500,0\n"))
                  .error.contains("extended 'WAHR': must be 0, 1, true or false"));
}

TEST_F(AnalyseBusTest, NumbersAreQuotedAsTheyStandThere) {
  const auto with = [&](const std::string& period) {
    return slow(file("t.csv", "name;id;extended;bytes;period_us\nA;1;0;7;" + period + "\n")).error;
  };
  EXPECT_TRUE(
      with("1.000,5").contains("period_us '1.000,5': must have one decimal point or comma, "
                               "and none between thousands"))
      << with("1.000,5");
  EXPECT_TRUE(with("1,000,5").contains("period_us '1,000,5': must have one")) << with("1,000,5");
  EXPECT_TRUE(with("2,5x").contains("period_us '2,5x': must be a number of microseconds"))
      << with("2,5x");
  EXPECT_TRUE(
      with("99999999999999999999999")
          .contains("period_us '99999999999999999999999': too large, or too many digits: at "
                    "most 18446744073709551 us"))
      << with("99999999999999999999999");
  EXPECT_TRUE(with("99999999999999999").contains("too large: at most 18446744073709551 us"))
      << with("99999999999999999");
}

TEST_F(AnalyseBusTest, TheEncodingOfATableIsNamedWithoutAMarkToo) {
  const std::string header = "name";
  std::string little;
  std::string big;
  for (const char c : header) {
    little += std::string{c, '\0'};
    big += std::string{'\0', c};
  }
  EXPECT_TRUE(
      slow(file("le.csv", little)).error.contains("the table is UTF-16LE: save it as UTF-8"));
  EXPECT_TRUE(slow(file("be.csv", big)).error.contains("the table is UTF-16BE: save it as UTF-8"));
  EXPECT_TRUE(slow(file("mark.csv", "\xff\xfe" + little)).error.contains("the table is UTF-16: "));
}

TEST_F(AnalyseBusTest, ErrorsThatLeaveNoTimeAreNamed) {
  const auto path = table("a,1,0,8,10000,10000,0\n");
  const auto done = slow(path, {"--faults", "1", "--fault-interval-ms", "0.1"});
  EXPECT_EQ(done.status, 1) << done.error;
  EXPECT_TRUE(
      done.out.contains("a is the first that is not bounded: the errors that are assumed (1 "
                        "within 0.1 ms) and what is sent again leave no time for it, without "
                        "them all are bounded."))
      << done.out;
}

}  // namespace
}  // namespace mlcca
