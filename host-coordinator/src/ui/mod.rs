//! The dashboard: one page that shows a fleet operator the site, and why each pile was chosen.
//!
//! The page is plain HTML, CSS and JavaScript modules, embedded in the binary: nothing is built,
//! nothing is fetched from elsewhere. It reads the WebSocket `GET /api/v1/changes` of the API and
//! nothing else, so it can't do more than any other reader of that API. `index.html` is the frame,
//! `app.js` ties the other modules together: `link.js` brings the messages, `model.js` keeps what
//! they say, `map.js` and `panels.js` draw it.

use axum::{Router, http::header, routing::get};

/// One file of the page.
struct Asset {
    path: &'static str,
    content_type: &'static str,
    body: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JAVASCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

/// An asset whose path is its file's name.
macro_rules! asset {
    ($name:literal, $content_type:expr) => {
        Asset { path: concat!("/", $name), content_type: $content_type, body: include_str!($name) }
    };
}

const ASSETS: &[Asset] = &[
    Asset { path: "/", ..asset!("index.html", HTML) },
    asset!("icon.svg", SVG),
    asset!("page.css", CSS),
    asset!("map.css", CSS),
    asset!("panels.css", CSS),
    asset!("app.js", JAVASCRIPT),
    asset!("dom.js", JAVASCRIPT),
    asset!("geometry.js", JAVASCRIPT),
    asset!("legend.js", JAVASCRIPT),
    asset!("link.js", JAVASCRIPT),
    asset!("map.js", JAVASCRIPT),
    asset!("model.js", JAVASCRIPT),
    asset!("motion.js", JAVASCRIPT),
    asset!("panels.js", JAVASCRIPT),
    asset!("symbols.js", JAVASCRIPT),
    asset!("tooltip.js", JAVASCRIPT),
    asset!("words.js", JAVASCRIPT),
];

/// What the browser may load: this server's own files and WebSocket. A name from a site file that
/// slipped into the page as markup could still run nothing and reach nobody.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     connect-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; \
     frame-ancestors 'none'";

/// The page's routes, to be merged into the API's router: `GET /` and the files it refers to.
///
/// Browsers must ask again at every load (`no-cache`): a page older than the coordinator that
/// serves it could misread its messages.
pub fn routes<S: Clone + Send + Sync + 'static>() -> Router<S> {
    ASSETS.iter().fold(Router::new(), |router, asset| {
        let headers = [
            (header::CONTENT_TYPE, asset.content_type),
            (header::CACHE_CONTROL, "no-cache"),
            (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        ];
        router.route(asset.path, get(move || async move { (headers, asset.body) }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::{
        io::{AsyncReadExt, AsyncWriteExt},
        net::{TcpListener, TcpStream},
    };

    /// Every double-quoted string of a file.
    fn quoted(body: &str) -> impl Iterator<Item = &str> {
        body.split('"').skip(1).step_by(2)
    }

    /// The paths of the page's own files that a file names in double quotes.
    fn references(asset: &Asset) -> Vec<String> {
        quoted(asset.body)
            .filter(|text| [".js", ".css", ".svg"].iter().any(|end| text.ends_with(end)))
            .map(|text| format!("/{}", text.trim_start_matches(['.', '/'])))
            .collect()
    }

    #[test]
    fn every_file_the_page_refers_to_is_served() {
        let served: Vec<_> = ASSETS.iter().map(|asset| asset.path).collect();
        let referred: Vec<_> = ASSETS.iter().flat_map(references).collect();
        for path in &referred {
            assert!(served.contains(&path.as_str()), "{path} is not served");
        }
        for path in served.iter().filter(|path| **path != "/") {
            assert!(referred.iter().any(|other| other == path), "nothing uses {path}");
        }
    }

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        const NAMESPACE: &str = "http://www.w3.org/2000/svg";
        for asset in ASSETS {
            let body = asset.body.replace(NAMESPACE, "");
            for scheme in ["http://", "https://", "src=\"//", "href=\"//", "url("] {
                assert!(!body.contains(scheme), "{} has {scheme}", asset.path);
            }
        }
    }

    /// Names of sites, subareas and warnings come from files and wires: they may become text
    /// only.
    #[test]
    fn strings_never_become_markup_or_code() {
        for asset in ASSETS.iter().filter(|asset| asset.path.ends_with(".js")) {
            for door in
                ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "Function("]
            {
                assert!(!asset.body.contains(door), "{} uses {door}", asset.path);
            }
        }
    }

    async fn get_over_http(path: &str) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let server = tokio::spawn(async move {
            axum::serve(listener, routes::<()>()).await.unwrap();
        });
        let mut stream = TcpStream::connect(address).await.unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        server.abort();
        answer
    }

    #[tokio::test]
    async fn every_file_is_answered_whole_with_its_type_and_policy() {
        for asset in ASSETS {
            let answer = get_over_http(asset.path).await;
            let (head, body) = answer.split_once("\r\n\r\n").unwrap();
            assert!(head.starts_with("HTTP/1.1 200"), "{}: {head}", asset.path);
            assert!(head.contains(&format!("content-type: {}", asset.content_type)));
            assert!(head.contains("cache-control: no-cache"));
            assert!(head.contains("content-security-policy: default-src 'none'"));
            assert_eq!(body, asset.body);
        }
    }
}
