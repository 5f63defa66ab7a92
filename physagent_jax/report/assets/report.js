"use strict";
// A cursor runs through the plots of a clip as its video plays; pointing at a plot reads values,
// clicking goes to that frame. Everything on the page is readable without this script.
(() => {
  // The best video is stored once; its second player borrows the bytes.
  for (const video of document.querySelectorAll("video[data-same-as]")) {
    const original = document.getElementById(video.dataset.sameAs);
    if (original) video.src = original.src;
  }

  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const clips = new Map();
  for (const plot of document.querySelectorAll("figure.plot")) {
    const name = plot.dataset.clip;
    if (!clips.has(name)) {
      clips.set(name, { plots: [], video: document.querySelector(`video[data-clip="${CSS.escape(name)}"]`), frame: -1 });
    }
    const { left, right, width, last } = plot.dataset;
    clips.get(name).plots.push({
      plot,
      left: +left, right: +right, width: +width, last: Math.max(1, +last),
      cursor: plot.querySelector(".cursor"),
      outputs: [...plot.querySelectorAll("output")].map((node) => ({ node, values: node.dataset.values.split(";") })),
    });
  }

  function show(clip, frame) {
    if (frame === clip.frame) return;
    clip.frame = frame;
    for (const item of clip.plots) {
      const x = item.left + (item.right - item.left) * Math.min(1, frame / item.last);
      item.cursor.setAttribute("x1", x);
      item.cursor.setAttribute("x2", x);
      item.cursor.classList.add("live");
      for (const { node, values } of item.outputs) node.textContent = values[frame] ?? "";
    }
  }

  const frameTime = (clip) => +(clip.video?.dataset.frameDt ?? 0);
  const playing = (clip) => clip.video && frameTime(clip) > 0 && !clip.pointed;

  for (const clip of clips.values()) {
    for (const item of clip.plots) {
      const picture = item.plot.querySelector("svg");
      const frameAt = (event) => {
        const box = picture.getBoundingClientRect();
        const x = ((event.clientX - box.left) / box.width) * item.width;
        return Math.round(Math.min(1, Math.max(0, (x - item.left) / (item.right - item.left))) * item.last);
      };
      picture.addEventListener("pointermove", (event) => { clip.pointed = true; show(clip, frameAt(event)); });
      picture.addEventListener("pointerleave", () => { clip.pointed = false; });
      picture.addEventListener("click", (event) => {
        if (!clip.video || !frameTime(clip)) return;
        clip.video.pause();
        clip.video.currentTime = (frameAt(event) + 0.5) * frameTime(clip);
      });
    }
  }

  (function follow() {
    for (const clip of clips.values()) {
      if (playing(clip)) {
        const last = clip.plots[0].last;
        show(clip, Math.min(last, Math.floor(clip.video.currentTime / frameTime(clip) + 1e-3)));
      }
    }
    requestAnimationFrame(follow);
  })();

  // Videos out of sight rest; a reader who paused one, or prefers less motion, is not overruled.
  const seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting && !target.paused) {
        target.pause();
        target.dataset.resting = "yes";
      } else if (isIntersecting && target.dataset.resting) {
        delete target.dataset.resting;
        target.play().catch(() => {});
      }
    }
  });
  for (const video of document.querySelectorAll("video")) {
    if (calm) { video.autoplay = false; video.pause(); } else seen.observe(video);
  }
})();
