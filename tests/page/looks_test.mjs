// For everyone: phone, themes, keyboard, names for screen readers, sizes, an address that holds the view.
import assert from "node:assert/strict";
import { figures, sharp, until, withPage } from "./browser.mjs";

const phone = { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
const ready = (page) => until(async () => (await figures(page)).keyframes > 3, "keyframes");

/** Controls without a name, text below 12 px, and on a phone controls smaller than a thumb. */
function faults(page, least) {
  return page.evaluate((least) => {
    const seen = (element) => element.checkVisibility({ visibilityProperty: true }) && element.getClientRects().length > 0;
    const name = (element) => element.getAttribute("aria-label") ?? element.textContent.trim();
    const found = [];
    for (const element of [...document.querySelectorAll("button, input, canvas, [tabindex], [role=img]")].filter(seen)) {
      if (name(element) === "") found.push(`no name: ${element.outerHTML.slice(0, 120)}`);
      const { width, height } = element.getBoundingClientRect();
      if (element.matches("button") && Math.min(width, height) < least) found.push(`${width} x ${height} px: ${name(element)}`);
    }
    for (const element of [...document.querySelectorAll("body *")].filter(seen)) {
      const hasText = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim() !== "");
      if (hasText && parseFloat(getComputedStyle(element).fontSize) < 12) found.push(`small: ${element.textContent}`);
    }
    return found;
  }, least);
}

export const tests = {
  async "a browser without WebGL says so"(browser) {
    await withPage(browser, { allowed: /no WebGL 2/, before: () => (HTMLCanvasElement.prototype.getContext = () => null) }, async (page) => {
      await page.getByRole("alert").getByText("it has no WebGL 2").waitFor();
    });
  },

  async "on a phone nothing is wider than the page, and all is as large as a thumb"(browser, { picture }) {
    await withPage(browser, { context: phone, server: { pace: 4 } }, async (page) => {
      await ready(page);
      await picture(page, "phone");
      for (const tab of ["View", "Camera", "Robot", "Map", "Health"]) {
        await page.getByRole("group", { name: "Panels" }).getByRole("button", { name: tab }).tap();
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${tab} scrolls sideways`);
        assert.deepEqual(await faults(page, 44), [], tab);
        await picture(page, `phone_${tab.toLowerCase()}`);
      }
    });
  },

  async "every control has a name, no text is small, dark and light"(browser, { picture }) {
    await withPage(browser, { context: sharp, server: { pace: 4 } }, async (page) => {
      await ready(page);
      const folded = page.locator(".card.folded .head");
      while ((await folded.count()) > 0) await folded.first().click();
      assert.deepEqual(await faults(page, 24), []);
      await page.getByRole("button", { name: "Dark or light" }).click();
      assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
      await picture(page, "light");
    });
  },

  async "keys do it all, and ? tells them"(browser) {
    await withPage(browser, {}, async (page) => {
      await ready(page);
      await page.keyboard.press("?");
      await page.getByRole("dialog", { name: "Keys" }).waitFor();
      await page.keyboard.press("Escape");
      const points = page.getByRole("button", { name: "Points", exact: true });
      const before = await points.getAttribute("aria-pressed");
      await page.keyboard.press("2");
      assert.notEqual(await points.getAttribute("aria-pressed"), before);
      const yaw = await page.evaluate(() => window.lcmslam.view.yaw);
      await page.keyboard.press("ArrowLeft");
      assert.notEqual(await page.evaluate(() => window.lcmslam.view.yaw), yaw);
      await page.keyboard.press("r");
      assert.equal(await page.getByRole("button", { name: "Robot's view (r)" }).getAttribute("aria-pressed"), "true");
    });
  },

  async "a layer that is not shown is not asked for"(browser) {
    await withPage(browser, {}, async (page, server) => {
      await ready(page);
      await page.getByRole("button", { name: "Landmarks", exact: true }).click();
      await until(() => server.said.some(({ want }) => want && !want.includes("landmarks") && want.includes("mesh")), "want without landmarks");
      assert.equal(await page.evaluate(() => window.lcmslam.views.landmarks.root.visible), false);
      assert.ok(server.said.some(({ eye }) => eye?.length === 3), "where the viewer stands");
      assert.ok(server.said.some(({ got }) => got > 100_000), "what was received");
    });
  },

  async "a named view without a place fits the map once it is there"(browser) {
    await withPage(browser, { path: "#view=top", server: { pace: 4 } }, async (page) => {
      await ready(page);
      const view = () => page.evaluate(() => ({ name: window.lcmslam.view.name, pitch: window.lcmslam.view.pitch, distance: window.lcmslam.view.distance }));
      await until(async () => (await view()).distance > 3, "the whole map");
      const { name, pitch } = await view();
      assert.ok(name === "top" && pitch > 1.5, `${name}, ${pitch}`);
    });
  },

  async "the address holds the view"(browser) {
    await withPage(browser, { path: "#at=1,0.5,0.25&turn=0.5,0.75&far=3&on=grid&off=points" }, async (page) => {
      await ready(page);
      const { at, far } = await page.evaluate(() => ({ at: window.lcmslam.view.target.toArray(), far: window.lcmslam.view.distance }));
      assert.deepEqual([...at, far], [1, 0.5, 0.25, 3]);
      assert.equal(await page.getByRole("button", { name: "Free space" }).getAttribute("aria-pressed"), "true");
      await page.keyboard.press("-");
      await until(() => page.evaluate(() => /far=3\.54/.test(location.hash) && /on=grid/.test(location.hash)), "the new distance in the address");
    });
  },
};
