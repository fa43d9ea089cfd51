// Asks for news of the file, and shows them; scroll and the turn of the view stay.
const panel = document.getElementById("version"), ended = document.getElementById("ended");
const section = document.getElementById("dimensions");
const choices = document.getElementById("poses-of-view");
const viewer = startViewer(document.getElementById("view"));
const still = painter(document.createElement("canvas"));
const PICTURE = [280, 210].map(side => side * Math.min(window.devicePixelRatio || 1, 2));
const TRIES = 5, PAUSE = 1000;
let version = -1, pictures = [], keys = [], colors = "";

function showNews(news) {
  const chosen = viewer && keys[viewer.chosen()];
  document.title = news.title;
  panel.innerHTML = news.html;
  const cards = [...panel.querySelectorAll(".card")];
  keys = cards.map(card => card.dataset.key);
  if (news.view) {
    showPart(readPart(JSON.parse(news.view)), Math.max(0, keys.indexOf(chosen)));
    colors = "";
  }
  if (viewer && news.colors !== colors) {
    colors = news.colors;
    viewer.color(colors ? readColors(colors) : null);
  }
  version = news.version;
  panel.dataset.version = version;
  cards.forEach((card, k) => {
    const place = card.querySelector(".still");
    pictures[k].setAttribute("aria-label", place.getAttribute("aria-label"));
    place.replaceWith(pictures[k]);
  });
}
function showPart(part, place) {
  section.hidden = false;
  choices.replaceChildren(...part.poses.map((pose, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.show = k;
    button.textContent = `pose ${pose.label}`;
    return button;
  }));
  if (viewer) viewer.show(part, place);
  if (still) {
    [still.canvas.width, still.canvas.height] = PICTURE;
    still.load(part);
  }
  pictures = part.poses.map(pose => {
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = PICTURE;
    picture.className = "still";
    picture.setAttribute("role", "img");
    if (still) {
      still.draw(pose, USUAL);
      picture.getContext("2d").drawImage(still.canvas, 0, 0);
    }
    return picture;
  });
}
function say(text) {
  ended.hidden = !text;
  ended.firstElementChild.textContent = text;
}
const pause = () => new Promise(resolve => setTimeout(resolve, PAUSE));
async function follow() {
  let number = -1, failures = 0;
  while (failures < TRIES) {
    try {
      const answer = await fetch(`news?after=${number}&version=${version}`);
      if (!answer.ok) throw new Error(answer.statusText);
      if (answer.status !== 204) {
        const news = await answer.json();
        number = news.number;
        showNews(news);
      }
      failures = 0;
      say("");
    } catch (error) {
      failures++;
      say(`No news of the file: ${error.message}.`);
      await pause();
    }
  }
  say("The program that follows the file has ended. This is what it said last.");
}
follow();
