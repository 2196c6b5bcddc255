// Drives the page in a test: moves sliders by input events, compares pixels with `stratus render`, and reports.
"use strict";
(async () => {
  const report = {};
  const say = () => {
    const lines = document.createElement("pre");
    lines.id = "report";
    lines.textContent = Object.entries({ ...report, errors: pageErrors.join("; ") || "none" })
      .map(([name, value]) => `report ${name} = ${value}`).join("\n");
    document.body.append(lines);
  };
  const move = (id, value) => {
    byId(id).value = value;
    byId(id).dispatchEvent(new Event("input", { bubbles: true }));
  };
  /** Until what was asked for is drawn, smooth edges included. */
  const settled = () => new Promise((resolve) => { setTimeout(resolve, 1000); });
  /** Red, green and blue of one half, rows from the top. */
  const pixelsOf = (half, size) => {
    const { gl } = picture, bytes = new Uint8Array(4 * size * size);
    gl.readPixels(half === 0 ? 0 : byId("picture").width - size, 0, size, size, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    const rows = Array.from({ length: size }, (_, y) => bytes.subarray(4 * size * (size - 1 - y), 4 * size * (size - y)));
    return rows.flatMap((row) => [...row]);
  };
  /** Of a rendered picture's half: the largest difference, how many bytes are lit, and how many of these are within 1. */
  const compared = (image, half, size) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * size, size];
    const pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    const expected = pen.getImageData(half * size, 0, size, size).data;
    const result = { largest: 0, near: 0, lit: 0 };
    pixelsOf(half, size).forEach((value, i) => {
      const difference = Math.abs(value - expected[i]), isLit = i % 4 < 3 && expected[i] > 30;
      result.largest = Math.max(result.largest, difference);
      result.lit += isLit;
      result.near += isLit && difference <= 1;
    });
    return result;
  };
  const moveSliders = async () => {
    document.querySelector("input[value=sphere]").click();
    await settled();
    const before = pixelsOf(1, size);
    move("depth", -0.3);
    await settled();
    report.moved = pixelsOf(1, size).filter((value, i) => Math.abs(value - before[i]) > 8).length;
    report.depth = byId("depth").parentElement.querySelector("output").textContent;
    const azimuth = byId("camera-azimuth").value;
    byId("frame").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
    report.turned = Number(byId("camera-azimuth").value) - Number(azimuth);
    document.querySelector("input[value=rings]").click();
    move("depth", -1.3);
    await settled();
    const places = Array.from({ length: 100 }, (_, k) => [k / 100, 0.5]);
    for (const zone of [0, 1]) {
      state.pointer = places.find((place) => picture.at(view(), ...place).zone === zone);
      showValues();
      report[`zone-${zone}`] = ["value-all", "angles"].map((id) => byId(id).textContent).join();
    }
    move("depth", -0.3);
    document.querySelector("input[value=lobes]").click();
    await settled();
    report.lobe = Math.max(...state.lobes[1][0]) / Math.max(...state.lobes[0][0]);
  };
  const size = 96;
  try {
    const images = {};
    for (const name of Object.keys(rendered)) {
      images[name] = new Image();
      const loaded = new Promise((resolve) => { images[name].onload = resolve; });
      images[name].src = rendered[name];
      await loaded;
    }
    await started;
    byId("frame").style.width = `${2 * size + 2}px`;
    for (const [name, settings] of Object.entries(scenesToCompare)) {
      document.querySelector(`input[value=${name}]`).click();
      for (const [id, value] of Object.entries(settings)) move(id, value);
      await settled();
      draw(1);
      for (const [half, orders] of ["once", "all"].entries()) {
        for (const [what, number] of Object.entries(compared(images[name], half, size)))
          report[`${name}-${orders}-${what}`] = number;
      }
    }
    report.scenes = scenes.join();
    if (!isOneSided) await moveSliders();
  } catch (error) {
    pageErrors.push(String(error));
  }
  say();
})();
