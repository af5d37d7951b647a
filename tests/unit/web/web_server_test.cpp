#include <lcmslam/web/web_server.hpp>

#include <gtest/gtest.h>
#include <atomic>
#include <fstream>
#include <thread>

#include "tests/support/web_client.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using testing::WebClient;

class WebServerTest : public ::testing::Test {
 protected:
  WebServerTest() {
    fs::create_directories(folder_ / "inner");
    write("index.html", "<p>the page</p>");
    write("page.js", std::string(20'000, 'j'));
    write("inner/secret.txt", "secret");
    write("../secret.txt", "secret");
    settings_.port = 0;
  }
  ~WebServerTest() override { fs::remove_all(folder_.parent_path()); }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

  WebServer& server() {
    if (!server_) {
      WebServer::Handlers handlers;
      handlers.command = [this](std::uint64_t who, const std::string& request,
                                const WebServer::Reply& reply) {
        last_who_ = who;
        if (request == "much") return reply(std::string(1'000'000, 'm'));
        if (request == "later") {
          later_ = reply;
          return;
        }
        reply("answer to " + request);
      };
      handlers.closed = [this](std::uint64_t who) { closed_ = who; };
      server_ = std::make_unique<WebServer>(settings_, folder_, board_, handlers);
    }
    return *server_;
  }

  template <class Condition>
  static bool soon(const Condition& condition) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (!condition() && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
  }

  fs::path folder_ = fs::path(::testing::TempDir()) / ("web-" + std::to_string(getpid())) / "page";
  WebSettings settings_;
  Board board_;
  std::atomic<std::uint64_t> last_who_{0}, closed_{0};
  WebServer::Reply later_;
  std::unique_ptr<WebServer> server_;
};

void put(Board& board, const std::string& key, std::size_t size) {
  board.put({"points", key, "{}", std::make_shared<const std::string>(size, 'x'), Haste::bulk, 0, {}});
}

TEST_F(WebServerTest, ServesItsFilesAndNoOthers) {
  WebClient client(server().port());
  const std::string page = client.get("/");
  EXPECT_EQ(page.rfind("HTTP/1.1 200", 0), 0u) << page;
  EXPECT_NE(page.find("<p>the page</p>"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'self'"), std::string::npos);
  EXPECT_NE(page.find("nosniff"), std::string::npos);
  EXPECT_NE(client.get("/page.js?x=1").find("text/javascript"), std::string::npos);
  for (const char* path : {"/inner/secret.txt", "/../secret.txt", "/..%2fsecret.txt", "//etc/passwd",
                           "/page.js/", "/%2e%2e/secret.txt"}) {
    WebClient other(server().port());
    EXPECT_EQ(other.get(path).rfind("HTTP/1.1 404", 0), 0u) << path;
  }
}

TEST_F(WebServerTest, PacksFilesForThoseWhoAskAndSaysWhatIsKnownAlready) {
  WebClient client(server().port());
  const std::string packed = client.get("/page.js", "Accept-Encoding: gzip\r\n");
  EXPECT_NE(packed.find("Content-Encoding: gzip"), std::string::npos);
  EXPECT_LT(packed.size(), 2000u);
  const std::size_t tag = packed.find("ETag: ") + 6;
  const std::string known = packed.substr(tag, packed.find("\r\n", tag) - tag);
  EXPECT_EQ(client.get("/page.js", "If-None-Match: " + known + "\r\n").rfind("HTTP/1.1 304", 0), 0u);
}

TEST_F(WebServerTest, BadRequestsAreRefusedAndCounted) {
  WebClient posts(server().port());
  posts.send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
  EXPECT_EQ(posts.response().rfind("HTTP/1.1 405", 0), 0u);
  WebClient large(server().port());
  EXPECT_NE(large.get("/", "X: " + std::string(20'000, 'x') + "\r\n").rfind("HTTP/1.1 200", 0), 0u);
  WebClient garbage(server().port());
  garbage.send("\x16\x03\x01 hello\r\n\r\n");
  EXPECT_NE(garbage.response().rfind("HTTP/1.1 200", 0), 0u);
  EXPECT_TRUE(soon([&] { return server().counts().bad >= 3; })) << server().counts().bad;
}

TEST_F(WebServerTest, ABrowserIsSentTheBoardAndWhatChanges) {
  put(board_, "1", 100);
  WebClient client(server().port());
  ASSERT_TRUE(client.open_socket("/live"));
  const auto first = client.hear();
  ASSERT_TRUE(first);
  EXPECT_NE(first->find(R"("key":"1")"), std::string::npos);
  put(board_, "2", 100);
  const auto second = client.hear();
  ASSERT_TRUE(second);
  EXPECT_NE(second->find(R"("key":"2")"), std::string::npos);
  EXPECT_EQ(server().counts().clients, 1);
}

TEST_F(WebServerTest, AnswersCommandsNowAndLaterAndSaysWhenABrowserLeaves) {
  {
    WebClient client(server().port());
    ASSERT_TRUE(client.open_socket("/command"));
    ASSERT_TRUE(client.say("hello"));
    EXPECT_EQ(client.hear(), "answer to hello");
    ASSERT_TRUE(client.say("later"));
    ASSERT_TRUE(client.say("now"));
    EXPECT_EQ(client.hear(), "answer to now");
    std::thread([&] { later_("at last"); }).join();
    EXPECT_EQ(client.hear(), "at last");
    ASSERT_TRUE(client.say("later"));
  }
  EXPECT_TRUE(soon([&] { return closed_ == last_who_; }));
  later_("too late");  // nobody hears it
  server_.reset();
  later_("much too late");
}

TEST_F(WebServerTest, TheAddressOfAllInterfacesIsOneThatOthersCanOpen) {
  settings_.address = "0.0.0.0";
  settings_.token = "open-sesame";
  char name[256] = "";
  ASSERT_EQ(gethostname(name, sizeof name - 1), 0);
  const std::string port = std::to_string(server().port());
  EXPECT_EQ(server().address(), "http://" + std::string(name) + ":" + port + "/?token=open-sesame");
}

TEST_F(WebServerTest, ForeignSitesAndWrongTokensAreRefusedAndCounted) {
  WebClient foreign(server().port());
  EXPECT_FALSE(foreign.open_socket("/live", "Origin: http://evil.example\r\n"));
  EXPECT_TRUE(soon([&] { return server().counts().strangers == 1; }));
  server_.reset();
  settings_.token = "open-sesame";
  EXPECT_NE(server().address().find("?token=open-sesame"), std::string::npos);
  WebClient unknown(server().port()), known(server().port()), cookie(server().port());
  const std::string port = std::to_string(server().port());
  EXPECT_EQ(unknown.get("/").rfind("HTTP/1.1 401", 0), 0u);
  EXPECT_NE(known.get("/?token=open-sesame")
                .find("Set-Cookie: lcmslam_token_" + port + "=open-sesame; HttpOnly; SameSite=Strict"),
            std::string::npos);
  EXPECT_TRUE(cookie.open_socket("/command", "Cookie: lcmslam_token_" + port + "=open-sesame\r\n"));
  EXPECT_FALSE(WebClient(server().port()).open_socket("/command"));
}

TEST_F(WebServerTest, TooManyAreRefusedAndTheOthersStay) {
  settings_.most_clients = 2;
  WebClient a(server().port()), b(server().port()), c(server().port());
  EXPECT_TRUE(a.open_socket("/live"));
  EXPECT_TRUE(b.open_socket("/live"));
  EXPECT_FALSE(c.open_socket("/live"));
  EXPECT_EQ(server().counts().too_many, 1);
  put(board_, "1", 10);
  EXPECT_TRUE(a.hear());
}

TEST_F(WebServerTest, WhoTakesNothingIsLetGoAndOthersAreServedMeanwhile) {
  settings_.patience = 1;
  WebClient idle(server().port(), 4096), other(server().port());
  ASSERT_TRUE(idle.open_socket("/live"));
  ASSERT_TRUE(other.open_socket("/live"));
  for (int i = 0; i < 200; ++i) put(board_, std::to_string(i), 10'000);
  std::size_t bytes = 0;
  int messages = 0;
  while (messages < 200) {
    const auto message = other.hear();
    if (!message) break;
    bytes += message->size();
    ++messages;
    other.say(R"({"got":)" + std::to_string(bytes) + "}");
  }
  EXPECT_EQ(messages, 200);
  EXPECT_TRUE(soon([&] { return server().counts().let_go == 1; }));
  EXPECT_EQ(server().counts().clients, 1);
}

TEST_F(WebServerTest, FiveOfTwentyWhoNeverReadHoldUpNobody) {
  settings_.patience = 2;
  std::vector<std::unique_ptr<WebClient>> idle, others;
  for (int i = 0; i < 20; ++i) {
    auto& clients = i % 4 == 0 ? idle : others;
    clients.push_back(std::make_unique<WebClient>(server().port(), i % 4 == 0 ? 4096 : 0));
    ASSERT_TRUE(clients.back()->open_socket("/live"));
  }
  for (int i = 0; i < 20; ++i) put(board_, std::to_string(i), 10'000);
  for (const auto& client : others) {
    std::size_t bytes = 0;
    for (int i = 0; i < 20; ++i) {
      const auto message = client->hear();
      ASSERT_TRUE(message);
      client->say(R"({"got":)" + std::to_string(bytes += message->size()) + "}");
    }
  }
  EXPECT_TRUE(soon([&] { return server().counts().let_go == 5; })) << server().counts().let_go;
  EXPECT_EQ(server().counts().clients, 15);
}

TEST_F(WebServerTest, LongMessagesGoInPartsToThoseWhoJoinThem) {
  put(board_, "1", 200'000);
  WebClient client(server().port()), plain(server().port());
  ASSERT_TRUE(client.open_socket("/live?parts=1"));
  ASSERT_TRUE(plain.open_socket("/live"));
  const auto part = client.hear(), whole = plain.hear();
  ASSERT_TRUE(part && whole);
  EXPECT_NE(
      part->find(R"({"channel":"part","key":"bulk","at":0,"of":)" + std::to_string(whole->size()) + "}"),
      std::string::npos);
  EXPECT_GT(whole->size(), 200'000u);
}

TEST_F(WebServerTest, TellsThePageThatAllOfTheBoardHasCome) {
  put(board_, "1", 100);
  WebClient client(server().port());
  ASSERT_TRUE(client.open_socket("/live?parts=1"));
  ASSERT_TRUE(client.hear());
  const auto whole = client.hear();
  ASSERT_TRUE(whole);
  EXPECT_NE(whole->find(R"("channel":"whole")"), std::string::npos);
}

TEST_F(WebServerTest, HalfARequestIsNotWaitedForLong) {
  settings_.patience = 1;
  WebClient half(server().port());
  half.send("GET / HTTP/1.1\r\nHost:");
  EXPECT_EQ(WebClient(server().port()).get("/").rfind("HTTP/1.1 200", 0), 0u);
  EXPECT_TRUE(half.is_closed());
}

TEST_F(WebServerTest, StrangersWhoSayNothingKeepNobodyOut) {
  settings_.most_clients = 1;  // four connections that are no sockets
  settings_.token = "open-sesame";
  settings_.patience = 600;
  std::vector<std::unique_ptr<WebClient>> strangers;
  for (int i = 0; i < 4; ++i) {
    strangers.push_back(std::make_unique<WebClient>(server().port()));
    strangers.back()->send("GET / HTTP/1.1\r\nHost:");
  }
  WebClient browser(server().port());
  EXPECT_EQ(browser.get("/?token=open-sesame").rfind("HTTP/1.1 200", 0), 0u);
  EXPECT_TRUE(strangers[0]->is_closed()) << "who has waited longest";
  EXPECT_EQ(server().counts().too_many, 1);
  EXPECT_TRUE(WebClient(server().port()).open_socket("/live?token=open-sesame"));
  EXPECT_EQ(browser.get("/page.js?token=open-sesame").rfind("HTTP/1.1 200", 0), 0u)
      << "whose request came last stays";
  strangers[3]->send(" localhost\r\n\r\n");
  EXPECT_EQ(strangers[3]->response().rfind("HTTP/1.1 401", 0), 0u);
}

TEST_F(WebServerTest, WhoAsksAndDoesNotListenIsLetGo) {
  WebClient client(server().port(), 4096);
  ASSERT_TRUE(client.open_socket("/command"));
  for (int i = 0; i < 200; ++i) client.say("much");
  EXPECT_TRUE(soon([&] { return closed_ > 0; }));
  EXPECT_EQ(server().counts().bad, 1);
  EXPECT_LT(server().counts().commands, 80);
}

TEST_F(WebServerTest, AServerThatEndsHangsUpAndForgets) {
  settings_.patience = 600;
  WebServer::Handlers handlers;
  const auto held = std::make_shared<int>(0);
  handlers.command = [held](std::uint64_t, const std::string&, const WebServer::Reply&) {};
  server_ = std::make_unique<WebServer>(settings_, folder_, board_, handlers);
  WebClient half(server().port()), idle(server().port()), live(server().port()), command(server().port());
  half.send("GET / HTT");
  idle.get("/");
  ASSERT_TRUE(live.open_socket("/live"));
  ASSERT_TRUE(command.open_socket("/command"));
  handlers = {};
  server_.reset();
  for (WebClient* client : {&half, &idle, &live, &command}) EXPECT_TRUE(client->is_closed());
  EXPECT_EQ(held.use_count(), 1);
}

TEST_F(WebServerTest, MessagesThatAreNoneEndTheSocketAlone) {
  std::int64_t bad = 0;
  const auto is_refused = [&](const std::string& socket, const std::string& text, unsigned char opcode) {
    {
      WebClient client(server().port());
      if (!client.open_socket(socket) || !client.say(text, opcode) || !client.is_closed()) return false;
    }
    ++bad;
    return soon([&] { return server().counts().bad == bad; });
  };
  constexpr unsigned char text = 0x81, binary = 0x82;
  for (const char* said : {"garbage", R"({"got":-1e99})", R"({"eye":[1]})", "[]", R"({"want":{"a":1}})"})
    EXPECT_TRUE(is_refused("/live", said, text)) << said;
  EXPECT_TRUE(is_refused("/live", std::string(6000, 'x'), text));
  EXPECT_TRUE(is_refused("/command", "x", binary));
  EXPECT_TRUE(is_refused("/command", std::string(70'000, 'x'), text));
  EXPECT_TRUE(WebClient(server().port()).open_socket("/live"));
}

TEST_F(WebServerTest, ATakenPortIsNamed) {
  settings_.port = server().port();
  try {
    const WebServer second(settings_, folder_, board_, {});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(settings_.port)), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("port 0"), std::string::npos) << error.what();
  }
  fs::remove(folder_ / "index.html");
  settings_.port = 0;
  EXPECT_THROW(WebServer(settings_, folder_, board_, {}), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
