// A client of `haptic-tracing serve`: sends poses, receives what each listener feels.
// One file for .NET Standard 2.0 (Unity 2021 and later), without dependencies.

using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Net.WebSockets;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;

namespace HapticTracing
{
    /// <summary>What a listener feels. Level and margin in decibels, NaN for silence.</summary>
    public struct Level
    {
        public double Decibels, Margin;
        public bool IsSilent { get { return double.IsNaN(Decibels); } }

        /// <summary>The peak amplitude of a tone of this level, 0 to 1, such as for a rumble motor.</summary>
        public double Amplitude { get { return IsSilent ? 0 : Math.Min(Math.Sqrt(2) * Math.Pow(10, Decibels / 20), 1); } }
    }

    /// <summary>An impact that was found: its time in seconds, its objects and its energy in joules.</summary>
    public struct Impact
    {
        public double Time, Energy;
        public string First, Second;
    }

    /// <summary>The client. Steps are sent in the background; what comes back is told by events, within <see cref="Update"/>.</summary>
    public sealed class Client : IDisposable
    {
        /// <summary>The levels of a step, by listener.</summary>
        public event Action<IReadOnlyDictionary<string, Level>> Levels;
        public event Action<Impact> Impacted;
        /// <summary>A message that the server refused: JSON pointer and reason; or the end of the connection.</summary>
        public event Action<string, string> Failed;

        readonly ClientWebSocket socket = new ClientWebSocket();
        readonly CancellationTokenSource ended = new CancellationTokenSource();
        readonly ConcurrentQueue<Dictionary<string, object>> answers = new ConcurrentQueue<Dictionary<string, object>>();
        readonly ConcurrentQueue<string> messages = new ConcurrentQueue<string>();
        readonly SemaphoreSlim queued = new SemaphoreSlim(0);
        readonly Dictionary<string, double[]> sent = new Dictionary<string, double[]>(), moved = new Dictionary<string, double[]>();
        bool waiting, stepped;
        double time;

        /// <summary>The names that the server's scene has, once connected.</summary>
        public IReadOnlyList<string> Objects { get; private set; } = new string[0];
        public IReadOnlyList<string> Sources { get; private set; } = new string[0];
        public IReadOnlyList<string> Listeners { get; private set; } = new string[0];
        public bool IsConnected { get; private set; }

        /// <summary>Connect. hello: further keys of the first message, such as token, up, handedness, metres_per_unit, scene.</summary>
        public async Task ConnectAsync(string url, IDictionary<string, object> hello = null)
        {
            await socket.ConnectAsync(new Uri(url), ended.Token).ConfigureAwait(false);
            var message = new Dictionary<string, object>(hello ?? new Dictionary<string, object>());
            message["type"] = "hello";
            message["version"] = 1;
            Send(message);
            _ = Task.Run(SendAll);
            _ = Task.Run(ReceiveAll);
        }

        /// <summary>Where an object is: position and rotation in the axes and units said in hello. Sent with the next step.</summary>
        public void Move(string name, double x, double y, double z, double qw, double qx, double qy, double qz)
        {
            var pose = new[] { x, y, z, qw, qx, qy, qz };
            double[] last;
            if (sent.TryGetValue(name, out last) && ((System.Collections.IStructuralEquatable)last).Equals(pose, EqualityComparer<double>.Default)) return;
            sent[name] = moved[name] = pose;
        }

        /// <summary>Go on to a time in seconds. While an answer is awaited, the newest state waits.</summary>
        public void Step(double seconds)
        {
            time = seconds;
            stepped = true;
            Flush();
        }

        /// <summary>Play the signal of a source with triggers once.</summary>
        public void Play(string source) { Send(new Dictionary<string, object> { { "type", "play" }, { "source", source } }); }

        /// <summary>Fall silent and forget contacts.</summary>
        public void Stop() { Send(new Dictionary<string, object> { { "type", "stop" } }); }

        /// <summary>Add, replace or remove: kind, then object, source or listener, as in a scene file, or a name to remove.</summary>
        public void Change(string kind, string what, object item)
        {
            if (kind == "remove") sent.Remove(item as string ?? "");
            Send(new Dictionary<string, object> { { "type", kind }, { what, item } });
        }

        /// <summary>Tell what has come back. Call it once a frame, on the thread that handles the events.</summary>
        public void Update()
        {
            Dictionary<string, object> answer;
            while (answers.TryDequeue(out answer)) Tell(answer);
            Flush();
        }

        public void Dispose()
        {
            ended.Cancel();
            socket.Dispose();
        }

        void Flush()
        {
            if (!stepped || waiting || !IsConnected) return;
            var poses = new Dictionary<string, object>();
            foreach (var pair in moved) poses[pair.Key] = pair.Value;
            moved.Clear();
            stepped = false;
            waiting = true;
            Send(new Dictionary<string, object> { { "type", "step" }, { "time", time }, { "poses", poses } });
        }

        void Tell(Dictionary<string, object> answer)
        {
            switch ((string)answer["type"])
            {
                case "scene":
                    Objects = Names(answer["objects"]);
                    Sources = Names(answer["sources"]);
                    Listeners = Names(answer["listeners"]);
                    IsConnected = true;
                    break;
                case "frame":
                    waiting = false;
                    var levels = new Dictionary<string, Level>();
                    foreach (var pair in (Dictionary<string, object>)answer["levels"])
                    {
                        var felt = (Dictionary<string, object>)pair.Value;
                        levels[pair.Key] = new Level { Decibels = Number(felt["level"]), Margin = Number(felt["margin"]) };
                    }
                    if (Levels != null) Levels(levels);
                    foreach (Dictionary<string, object> found in (List<object>)answer["impacts"])
                    {
                        var names = Names(found["objects"]);
                        var impact = new Impact { Time = Number(found["time"]), Energy = Number(found["energy"]), First = names[0], Second = names[1] };
                        if (Impacted != null) Impacted(impact);
                    }
                    break;
                case "error":
                    waiting = false;
                    if (Failed != null) Failed((string)answer["where"], (string)answer["message"]);
                    break;
            }
        }

        static double Number(object value) { return value is double ? (double)value : double.NaN; }

        static List<string> Names(object list) { return ((List<object>)list).ConvertAll(name => (string)name); }

        void Send(Dictionary<string, object> message)
        {
            messages.Enqueue(Json.Write(message));
            queued.Release();
        }

        async Task SendAll()
        {
            try
            {
                while (true)
                {
                    await queued.WaitAsync(ended.Token).ConfigureAwait(false);
                    string message;
                    messages.TryDequeue(out message);
                    var bytes = new ArraySegment<byte>(Encoding.UTF8.GetBytes(message));
                    await socket.SendAsync(bytes, WebSocketMessageType.Text, true, ended.Token).ConfigureAwait(false);
                }
            }
            catch (Exception error) { End(error); }
        }

        async Task ReceiveAll()
        {
            var buffer = new ArraySegment<byte>(new byte[1 << 16]);
            try
            {
                while (true)
                {
                    using (var whole = new MemoryStream())
                    {
                        WebSocketReceiveResult part;
                        do
                        {
                            part = await socket.ReceiveAsync(buffer, ended.Token).ConfigureAwait(false);
                            if (part.MessageType == WebSocketMessageType.Close) throw new IOException("the server has closed the connection");
                            whole.Write(buffer.Array, 0, part.Count);
                        } while (!part.EndOfMessage);
                        if (part.MessageType == WebSocketMessageType.Text)
                            answers.Enqueue((Dictionary<string, object>)Json.Read(Encoding.UTF8.GetString(whole.ToArray())));
                    }
                }
            }
            catch (Exception error) { End(error); }
        }

        void End(Exception error)
        {
            if (ended.IsCancellationRequested) return;
            ended.Cancel();
            answers.Enqueue(new Dictionary<string, object> { { "type", "error" }, { "where", "" }, { "message", error.Message } });
        }
    }

    /// <summary>JSON as dictionaries, lists, strings, doubles, booleans and null.</summary>
    static class Json
    {
        public static string Write(object value)
        {
            var text = new StringBuilder();
            Write(value, text);
            return text.ToString();
        }

        static void Write(object value, StringBuilder text)
        {
            if (value == null) text.Append("null");
            else if (value is bool) text.Append((bool)value ? "true" : "false");
            else if (value is string) WriteText((string)value, text);
            else if (value is IDictionary<string, object>) WriteAll(text, '{', '}', (IDictionary<string, object>)value, pair => { WriteText(pair.Key, text); text.Append(':'); Write(pair.Value, text); });
            else if (value is double[]) WriteAll(text, '[', ']', (double[])value, item => Write(item, text));
            else if (value is System.Collections.IEnumerable) WriteAll(text, '[', ']', Items((System.Collections.IEnumerable)value), item => Write(item, text));
            else text.Append(Convert.ToDouble(value, CultureInfo.InvariantCulture).ToString("R", CultureInfo.InvariantCulture));
        }

        static IEnumerable<object> Items(System.Collections.IEnumerable list) { foreach (var item in list) yield return item; }

        static void WriteAll<T>(StringBuilder text, char open, char close, IEnumerable<T> items, Action<T> write)
        {
            text.Append(open);
            var first = true;
            foreach (var item in items)
            {
                if (!first) text.Append(',');
                first = false;
                write(item);
            }
            text.Append(close);
        }

        static void WriteText(string value, StringBuilder text)
        {
            text.Append('"');
            foreach (var c in value)
                if (c == '"' || c == '\\') text.Append('\\').Append(c);
                else if (c < ' ') text.Append("\\u").Append(((int)c).ToString("x4"));
                else text.Append(c);
            text.Append('"');
        }

        public static object Read(string text)
        {
            var place = 0;
            return Read(text, ref place);
        }

        static object Read(string text, ref int place)
        {
            Skip(text, ref place);
            switch (text[place])
            {
                case '{':
                    var members = new Dictionary<string, object>();
                    place++;
                    while (More(text, ref place, '}'))
                    {
                        var key = ReadText(text, ref place);
                        Skip(text, ref place);
                        place++; // the colon
                        members[key] = Read(text, ref place);
                    }
                    return members;
                case '[':
                    var items = new List<object>();
                    place++;
                    while (More(text, ref place, ']')) items.Add(Read(text, ref place));
                    return items;
                case '"': return ReadText(text, ref place);
                case 't': place += 4; return true;
                case 'f': place += 5; return false;
                case 'n': place += 4; return null;
            }
            var start = place;
            while (place < text.Length && "+-.eE0123456789".IndexOf(text[place]) >= 0) place++;
            return double.Parse(text.Substring(start, place - start), CultureInfo.InvariantCulture);
        }

        static bool More(string text, ref int place, char close)
        {
            Skip(text, ref place);
            if (text[place] == ',') { place++; Skip(text, ref place); }
            if (text[place] != close) return true;
            place++;
            return false;
        }

        static void Skip(string text, ref int place) { while (char.IsWhiteSpace(text[place])) place++; }

        static string ReadText(string text, ref int place)
        {
            var start = ++place;
            while (text[place] != '"') place += text[place] == '\\' ? 2 : 1;
            return Regex.Unescape(text.Substring(start, place++ - start));
        }
    }
}
