#include <lcmslam/web/access.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

using Verdict = Access::Verdict;

WebSettings at(const std::string& address, const std::string& token = "") {
  WebSettings settings;
  settings.address = address;
  settings.token = token;
  return settings;
}

TEST(Access, OnLoopBackWhoeverIsHereIsWelcome) {
  const Access access(at("127.0.0.1"));
  EXPECT_EQ(access.token(), "");
  for (const char* host : {"127.0.0.1:8642", "localhost:8642", "localhost", "[::1]:8642"})
    EXPECT_EQ(access.judge({"/", host, "", ""}), Verdict::granted) << host;
}

TEST(Access, ForeignNamesThatLeadHereAreRefused) {
  const Access access(at("127.0.0.1"));
  for (const char* host :
       {"evil.example:8642", "127.0.0.1.evil.example", "localhost.evil.example", "", "[evil"})
    EXPECT_EQ(access.judge({"/", host, "", ""}), Verdict::wrong_host) << host;
}

TEST(Access, PagesOfOtherSitesAreRefused) {
  const Access access(at("127.0.0.1"));
  const std::string host = "localhost:8642";
  EXPECT_EQ(access.judge({"/live", host, "http://localhost:8642", ""}), Verdict::granted);
  for (const char* origin :
       {"http://evil.example", "http://localhost:8643", "null", "http://localhost:8642.evil.example"})
    EXPECT_EQ(access.judge({"/live", host, origin, ""}), Verdict::wrong_origin) << origin;
}

TEST(Access, FromElsewhereTheTokenDecides) {
  const Access access(at("0.0.0.0", "open-sesame"));
  const auto judged = [&](const std::string& target, const std::string& cookie) {
    return access.judge({target, "robot.local:8642", "", cookie});
  };
  EXPECT_EQ(judged("/?token=open-sesame", ""), Verdict::granted);
  EXPECT_EQ(judged("/?a=b&token=open-sesame&c", ""), Verdict::granted);
  EXPECT_EQ(judged("/page.js", "a=b; lcmslam_token_8642=open-sesame"), Verdict::granted);
  for (const char* target : {"/", "/?token=", "/?token=open-sesam", "/?token=open-sesamE",
                             "/?xtoken=open-sesame", "/?token=open-sesame2", "/token=open-sesame"})
    EXPECT_EQ(judged(target, ""), Verdict::wrong_token) << target;
  EXPECT_EQ(judged("/", "xlcmslam_token_8642=open-sesame"), Verdict::wrong_token);
}

TEST(Access, ServersOnOneHostHaveCookiesOfTheirOwn) {
  const Access first(at("0.0.0.0", "open-sesame")), second(at("0.0.0.0", "open-barley"));
  const Access::Request to_first{"/", "robot:8642", "", ""}, to_second{"/", "robot:8643", "", ""};
  const std::string both = first.cookie(to_first) + "; " + second.cookie(to_second);
  EXPECT_EQ(first.judge({"/", "robot:8642", "", both}), Verdict::granted);
  EXPECT_EQ(second.judge({"/", "robot:8643", "", both}), Verdict::granted);
  EXPECT_EQ(first.judge({"/", "robot:8643", "", both}), Verdict::wrong_token);
  for (const char* host : {"robot", "[::1]", "robot:1;2"})
    EXPECT_EQ(first.cookie({"/", host, "", ""}), "lcmslam_token_80=open-sesame") << host;
}

TEST(Access, ATokenMayHaveWhatMeansSomethingInAddresses) {
  const std::string token = "Zm9v/YmFy+#%41==";
  const Access access(at("0.0.0.0", token));
  for (const std::string& target :
       {"/?token=" + query_value(token), std::string("/?token=Zm9v%2fYmFy%2B%23%2541%3D%3D&parts=1")})
    EXPECT_EQ(access.judge({target, "robot:8642", "", ""}), Verdict::granted) << target;
  EXPECT_EQ(query_value("a-B_1.~/ "), "a-B_1.~%2F%20");
  EXPECT_EQ(query_member("/?a=%&b=%4", "a") + query_member("/?a=%&b=%4", "b"), "%%4");
  EXPECT_EQ(query_member("/?a=%zz%+1", "a"), "%zz%+1");
}

TEST(Access, ATokenIsMadeWhereNoneIsGivenAndAnotherAtEachStart) {
  const Access first(at("0.0.0.0")), second(at("0.0.0.0"));
  EXPECT_EQ(first.token().size(), 32u);
  EXPECT_NE(first.token(), second.token());
}

TEST(Access, WrongSettingsAreNamed) {
  EXPECT_THROW(Access(at("nowhere")), std::runtime_error);
  EXPECT_THROW(Access(at("127.0.0.1", "open;sesame")), std::runtime_error);
  EXPECT_THROW(Access(at("0.0.0.0", "sesame")), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
